#include <doctest/doctest.h>

#include <csignal>
#include <thread>

#include "client/download.h"
#include "tests/client/raw_server.h"
#include "tests/client/run.h"

namespace rivage::client {
namespace {

using namespace std::chrono_literals;

constexpr auto kLimit = 500ms;
constexpr auto kSlack = 400ms;  // a busy machine

/// A transport whose time is over soon, and how long its calls took.
struct Timed {
    Interrupt interrupt;
    Transport transport;
    Clock::time_point start = Clock::now();

    explicit Timed(int port) : transport({{"127.0.0.1", port}, {}, {}}, interrupt) {
        std::signal(SIGPIPE, SIG_IGN);  // as the program does
        transport.setDeadline(start + kLimit);
    }
    [[nodiscard]] bool inTime() const {
        const auto time = Clock::now() - start;
        return time >= kLimit - 50ms && time < kLimit + kSlack;
    }
};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("time limit: a server that does not read an upload") {
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    socklen_t size = sizeof address;
    getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
    REQUIRE(listen(listener, 4) == 0);

    Timed timed(ntohs(address.sin_port));
    httplib::Request request = makeRequest("POST", "/v1/jobs");
    request.body.assign(std::size_t{30} << 20, 'x');
    const auto response = timed.transport.send(request);
    REQUIRE_FALSE(response);
    CHECK(response.error().exit == ExitCode::busy);
    CHECK(timed.inTime());
    close(listener);
}

TEST_CASE("time limit: a server that streams for ever") {
    std::atomic<bool> end{false};
    const auto flood = [&end](const std::string& head, const std::string& more) {
        return [&end, head, more](const std::string&, const RawConnection& connection) {
            connection.send(head);
            while (!end) connection.send(more);
        };
    };
    const std::string body = "HTTP/1.1 200 OK\r\nContent-Length: 1000000000000\r\n\r\n";
    RawServer bytes(flood(body, std::string(4096, 'x')));
    RawServer interim(flood("", "HTTP/1.1 102 Processing\r\n\r\n"));
    for (const int port : {bytes.port(), interim.port()}) {
        CAPTURE(port == bytes.port());
        Timed timed(port);
        const ByteStore store{[] { return true; }, [](std::string_view) { return true; }};
        const auto fetched = download(timed.transport, "/", store);
        REQUIRE_FALSE(fetched);
        CHECK(fetched.error().exit == ExitCode::busy);
        CHECK(timed.inTime());
    }
    end = true;
}

TEST_SUITE_END();

}  // namespace rivage::client
