#include "client/download.h"

#include <doctest/doctest.h>

#include "tests/client/fake_server.h"

namespace rivage::client {
namespace {

using namespace std::chrono_literals;

constexpr RetryPolicy kQuick{.base = 1ms, .cap = 5ms};

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("transport: only statuses that pass are tried again") {
    FakeServer server;
    std::atomic<int> calls{0};
    server.http.Get(R"(/(\d+))", [&](const httplib::Request& request, httplib::Response& response) {
        response.status = ++calls < 3 ? std::stoi(request.matches[1]) : 200;
    });
    server.start();
    Interrupt interrupt;
    Transport transport({{"127.0.0.1", server.port()}}, interrupt, kQuick);
    for (const int status : {408, 429, 502, 503, 504}) {
        CAPTURE(status);
        calls = 0;
        CHECK(transport.send(makeRequest("GET", "/" + std::to_string(status))));
        CHECK(calls == 3);
    }
    for (const int status : {400, 401, 404, 410, 413, 422, 500, 501}) {
        CAPTURE(status);
        calls = 0;
        CHECK_FALSE(transport.send(makeRequest("GET", "/" + std::to_string(status))));
        CHECK(calls == 1);
    }
}

TEST_CASE("transport: Retry-After is waited for") {
    FakeServer server;
    std::atomic<int> calls{0};
    server.http.Get("/", [&](const httplib::Request&, httplib::Response& response) {
        response.status = ++calls < 2 ? 503 : 200;
        response.set_header("Retry-After", "1");
    });
    server.start();
    Interrupt interrupt;
    Transport transport({{"127.0.0.1", server.port()}}, interrupt, kQuick);
    const auto start = Clock::now();
    CHECK(transport.send(makeRequest("GET", "/")));
    CHECK(Clock::now() - start >= 1s);
}

TEST_CASE("transport: a broken download begins again, an upload only with a key") {
    FakeServer server;
    std::atomic<int> calls{0};
    const auto half = [&](const httplib::Request&, httplib::Response& response) {
        const bool whole = ++calls == 2;
        response.set_content_provider(
            6, "text/plain", [whole](std::size_t offset, std::size_t, httplib::DataSink& sink) {
                sink.write(whole ? &"abcdef"[offset] : "abc", whole ? 6 - offset : 3);
                return whole;
            });
    };
    server.http.Get("/", half);
    server.http.Post("/", half);
    server.start();
    Interrupt interrupt;
    Transport transport({{"127.0.0.1", server.port()}}, interrupt, kQuick);
    std::string got;
    const ByteStore store{[&] { return got.clear(), true; },
                          [&](std::string_view bytes) { return got += bytes, true; }};
    CHECK(download(transport, "/", store));
    CHECK(got == "abcdef");
    CHECK(calls == 2);

    calls = 0;
    const auto posted = transport.send(makeRequest("POST", "/"));
    REQUIRE_FALSE(posted);
    CHECK(posted.error().exit == ExitCode::unreachable);
    CHECK(calls == 1);

    calls = 0;
    httplib::Request repeatable = makeRequest("POST", "/");
    repeatable.set_header("Idempotency-Key", "\"a\"");
    const auto repeated = transport.send(repeatable);
    REQUIRE(repeated);
    CHECK(repeated->body == "abcdef");
    CHECK(calls == 2);
}

TEST_CASE("transport: the deadline ends a request that hangs") {
    FakeServer server;
    server.http.Get("/", [&](const httplib::Request&, httplib::Response&) {
        std::this_thread::sleep_for(700ms);
    });
    server.start();
    Interrupt interrupt;
    Transport transport({{"127.0.0.1", server.port()}}, interrupt, kQuick);
    transport.setDeadline(Clock::now() + 100ms);
    const auto start = Clock::now();
    const auto response = transport.send(makeRequest("GET", "/"));
    REQUIRE_FALSE(response);
    CHECK(response.error().exit == ExitCode::busy);
    CHECK(Clock::now() - start < 600ms);
}

TEST_CASE("transport: a stop breaks off a request that hangs") {
    FakeServer server;
    std::atomic<bool> inside{false};
    server.http.Get("/", [&](const httplib::Request&, httplib::Response&) {
        inside = true;
        std::this_thread::sleep_for(700ms);
    });
    server.start();
    Interrupt interrupt;
    Transport transport({{"127.0.0.1", server.port()}}, interrupt, kQuick);
    std::thread person([&] {
        while (!inside) std::this_thread::sleep_for(1ms);
        interrupt.request();
    });
    const auto start = Clock::now();
    const auto response = transport.send(makeRequest("GET", "/"));
    person.join();
    REQUIRE_FALSE(response);
    CHECK(response.error().exit == ExitCode::cancelled);
    CHECK(Clock::now() - start < 600ms);
}

TEST_SUITE_END();

}  // namespace rivage::client
