#include "server/http/probe.h"

#include <doctest/doctest.h>

#include "server/net/listener.h"
#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;
using core::ErrorCode;
using server::probe;

namespace {

std::string atPort(int port) { return "127.0.0.1:" + std::to_string(port); }

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("probe: a server that serves is live, ready and started") {
    const TestServer server;
    for (const char* question : {"live", "ready", "started"}) {
        CAPTURE(question);
        CHECK(probe(atPort(server.adminAddress.port), question));
        CHECK(probe("0.0.0.0:" + std::to_string(server.adminAddress.port), question));
        CHECK(probe(":" + std::to_string(server.adminAddress.port), question));
    }
}

TEST_CASE("probe: a server that drains is live, but not ready") {
    const TestServer server;
    server.pool->beginDraining();
    const std::string admin = atPort(server.adminAddress.port);
    CHECK(probe(admin, "live"));
    const auto ready = probe(admin, "ready");
    REQUIRE_FALSE(ready);
    CHECK(ready.error().code == ErrorCode::internal);
    CHECK(ready.error().message.find("/problems/draining") != std::string::npos);
}

TEST_CASE("probe: nobody there, or nobody who answers") {
    const auto silent = server::listenOn({.host = "127.0.0.1", .port = 0});
    REQUIRE(silent);
    const auto before = server::Clock::now();
    for (const int port : {1, silent->address.port}) {
        CAPTURE(port);
        const auto answer = probe(atPort(port), "live");
        REQUIRE_FALSE(answer);
        CHECK(answer.error().code == ErrorCode::timedOut);
    }
    CHECK(server::Clock::now() - before < std::chrono::seconds(4));
}

TEST_CASE("reject: probe of a port that nobody knows") {
    for (const char* admin : {"off", "127.0.0.1:0", "nonsense"}) {
        CAPTURE(admin);
        const auto answer = probe(admin, "live");
        REQUIRE_FALSE(answer);
        CHECK(answer.error().code == ErrorCode::invalidOption);
    }
}
