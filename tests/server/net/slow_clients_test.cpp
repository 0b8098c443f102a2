#include <doctest/doctest.h>

#include <vector>

#include "tests/server/net/net_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;
using server::NetLimits;
using server::Phase;

namespace {

using Clients = std::vector<std::unique_ptr<RawClient>>;

Clients connectMany(const server::Address& address, int count, const std::string& bytes) {
    Clients clients;
    for (int i = 0; i < count; ++i) {
        clients.push_back(std::make_unique<RawClient>(address));
        REQUIRE(clients.back()->connected());
        clients.back()->send(bytes);
    }
    return clients;
}

bool isCanned(const std::string& answer, int status) {
    return statusOf(answer) == status &&
           answer.find("application/problem+json") != std::string::npos &&
           answer.find("X-Request-ID: ") != std::string::npos &&
           answer.find("Connection: close") != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("server/net");

TEST_CASE("slow heads: 200 hold no thread, others are answered at once, then each gets 408") {
    NetLimits limits;
    limits.headTimeout = 1500ms;
    const NetServer server(limits);
    const Clients slow = connectMany(server.address, 200, "GET /quick HTTP/1.1\r\nX: ");
    REQUIRE(server.waitFor(Phase::header, 200));
    CHECK(server.front->handlerThreads() == 0);
    double worst = 0;
    for (int i = 0; i < 20; ++i) {
        for (const auto& client : slow) client->send("x");
        worst = std::max(worst, quickMilliseconds(server.address));
    }
    CHECK(worst < 50);
    for (const auto& client : slow) CHECK(isCanned(client->readAll(), 408));
    CHECK(server.front->stats().timedOut == 200);
}

TEST_CASE("slow heads: a silent connection is closed without an answer") {
    NetLimits limits;
    limits.headTimeout = 100ms;
    const NetServer server(limits);
    RawClient client(server.address);
    CHECK(client.closedWithin(2s));
}

TEST_CASE("slow bodies: a trickle, a silence and a long body end with 408") {
    NetLimits rate;
    rate.bodyGrace = 300ms;
    NetLimits total;
    total.bodyTimeout = 300ms;
    const NetServer byRate(rate);
    const NetServer byTime(total);
    struct Case {
        const NetServer& server;
        std::size_t piece;  // bytes every 20 ms
    };
    for (const Case& slow : {Case{byRate, 0}, Case{byRate, 1}, Case{byTime, 2000}}) {
        CAPTURE(slow.piece);
        const auto began = std::chrono::steady_clock::now();
        RawClient client(slow.server.address);
        client.send("POST /upload HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\n");
        std::string answer;
        while (answer.empty() && std::chrono::steady_clock::now() - began < 3s) {
            client.send(std::string(slow.piece, 'x'));
            answer = client.readAnswer(20ms);
        }
        CHECK(statusOf(answer) == 408);
        CHECK(answer.find("Connection: close") != std::string::npos);
        CHECK(std::chrono::steady_clock::now() - began > 250ms);
    }
    CHECK(byRate.waitFor(Phase::body, 0));
}

TEST_CASE("regression: trailers without end are bounded as the body is") {
    NetLimits limits;
    limits.bodyBytes = 1 << 20;
    const NetServer server(limits);
    const RawClient client(server.address);
    client.send(
        "POST /upload HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n0\r\n");
    std::string lines;
    while (lines.size() < 64 << 10) lines += "X-A: 1\r\n";
    std::size_t sent = 0;
    while (sent < 64U << 20 && client.send(lines)) sent += lines.size();
    CHECK(sent < 16U << 20);
    CHECK(server.waitFor(Phase::body, 0));
    CHECK(quickMilliseconds(server.address) < 1000);
}

TEST_CASE("slow bodies: they hold threads, and yet others are answered at once") {
    const NetServer server;
    const Clients slow =
        connectMany(server.address, 100,
                    "POST /upload HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nstart");
    REQUIRE(server.waitFor(Phase::body, 100));
    double worst = 0;
    for (int i = 0; i < 10; ++i) worst = std::max(worst, quickMilliseconds(server.address));
    CHECK(worst < 50);
    for (const auto& client : slow) client->send(std::string(995, 'x'));
    for (const auto& client : slow) CHECK(client->readAnswer().ends_with("1000"));
}

TEST_CASE("slow readers: a lent answer holds no thread, and is cut off by the rate") {
    NetLimits limits;
    limits.writeGrace = 500ms;
    const NetServer server(limits);
    RawClient client(server.address, 4096);
    client.send(get("/lent"));
    REQUIRE(server.waitFor(Phase::stream, 1));
    CHECK(eventually([&] { return server.front->stats().activeRequests == 0; }));
    CHECK(server.big.use_count() >= 3);  // ours, the route's, and the tail's
    const long held = server.big.use_count();
    CHECK(eventually([&] { return server.big.use_count() == held - 1; }));
    CHECK(server.front->stats().timedOut == 1);
    CHECK(server.count(Phase::stream) == 0);
}

TEST_CASE("slow readers: whoever keeps reading gets every byte, lent or not") {
    NetLimits limits;
    limits.writeGrace = 500ms;
    const NetServer server(limits);
    for (const char* path : {"/lent", "/copied"}) {
        CAPTURE(path);
        RawClient client(server.address);
        client.send(get(path) + get("/quick"));
        std::this_thread::sleep_for(200ms);
        const std::string answer = client.readAnswer(20s);
        CHECK(answer.size() - answer.find("\r\n\r\n") - 4 == server.big->size());
        CHECK(answer.find_first_not_of('b', answer.find("\r\n\r\n") + 4) == std::string::npos);
        CHECK(client.readAnswer().ends_with("quick"));
    }
}

TEST_CASE("slow readers: bytes that are not lent are cut off by the rate too") {
    NetLimits limits;
    limits.writeGrace = 300ms;
    const NetServer server(limits);
    RawClient client(server.address, 4096);
    client.send(get("/copied"));
    REQUIRE(server.waitFor(Phase::stream, 1));
    CHECK(server.waitFor(Phase::stream, 0));
    CHECK(server.front->stats().activeRequests == 0);
}

TEST_CASE("streams: a client that leaves ends its stream") {
    const NetServer server;
    RawClient client(server.address);
    client.send(get("/stream"));
    CHECK(client.readUntil("0123456789").starts_with("HTTP/1.1 200"));
    CHECK(server.count(Phase::stream) == 1);
    client.close();
    CHECK(eventually([&] { return server.running == 0; }));
}

TEST_SUITE_END();
