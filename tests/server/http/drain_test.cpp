#include <doctest/doctest.h>

#include <thread>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBytes = "application/octet-stream";

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("drain: unready at once, no new jobs, what was accepted is answered") {
    TestServer server({.workers = 1, .queueLimit = 4});
    std::vector<std::thread> waiting;
    std::atomic<int> answered{0};
    for (int i = 0; i < 3; ++i)
        waiting.emplace_back([&, i] {
            auto client = server.client();
            const auto result = client.Post("/v1/regularize", "slow" + std::to_string(i), kBytes);
            CHECK(result);
            if (result) CHECK(result->status == 200);
            if (result && result->status == 200) ++answered;
        });
    REQUIRE(server.waitRunning(1));
    while (server.pool->stats().queued < 2) std::this_thread::sleep_for(1ms);
    auto admin = server.adminClient();
    CHECK(admin.Get("/readyz")->status == 200);

    server.pool->beginDraining();
    checkProblem(admin.Get("/readyz"), 503, "draining");
    CHECK(admin.Get("/livez")->status == 200);
    auto client = server.client();
    checkProblem(client.Post("/v1/jobs", "ok", kBytes), 503, "draining");
    CHECK(client.Get("/v1/jobs")->status == 200);

    server.gate.open = true;
    server.http->stop();
    for (std::thread& thread : waiting) thread.join();
    CHECK(answered == 3);
    CHECK(server.pool->idle());
}

TEST_CASE("drain: a waiting GET does not hold the end up") {
    TestServer server({.workers = 1, .queueLimit = 4});
    auto client = server.client();
    const std::string path = client.Post("/v1/jobs", "slow", kBytes)->get_header_value("Location");
    std::thread poller([&] {
        auto other = server.client();
        const auto result = other.Get(path, httplib::Headers{{"Prefer", "wait=60"}});
        CHECK(result);
    });
    while (server.service->waiting == 0) std::this_thread::sleep_for(1ms);
    const auto before = server::Clock::now();
    server.http->stop();
    CHECK(server::Clock::now() - before < 3s);
    poller.join();
}

TEST_SUITE_END();
