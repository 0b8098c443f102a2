#include <doctest/doctest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

TEST_SUITE_BEGIN("server/http");

TEST_CASE("overload: 50 clients on 2 workers: every answer is right or an honest 503") {
    const TestServer server({.workers = 2, .queueLimit = 4});
    std::atomic<int> right{0};
    std::atomic<int> refused{0};
    std::atomic<int> wrong{0};
    std::vector<std::thread> clients;
    for (int c = 0; c < 50; ++c)
        clients.emplace_back([&, c] {
            auto client = server.client();
            for (int i = 0; i < 20; ++i) {
                const std::string grid = "ok " + std::to_string(c) + "/" + std::to_string(i);
                const auto result = client.Post("/v1/regularize", grid, "application/octet-stream");
                if (result && result->status == 200 && result->body == "asset of " + grid)
                    ++right;
                else if (result && result->status == 503 &&
                         std::stoi(result->get_header_value("Retry-After")) >= 1)
                    ++refused;
                else
                    ++wrong;
            }
        });
    for (std::thread& client : clients) client.join();
    CHECK(wrong == 0);
    CHECK(right > 0);
    CHECK(right + refused == 1000);
    CHECK(server.pool->idle());
}

TEST_CASE("overload: health answers while every worker is busy") {
    TestServer server({.workers = 2, .queueLimit = 2});
    auto client = server.client();
    for (int i = 0; i < 4; ++i)
        REQUIRE(client.Post("/v1/jobs", "slow" + std::to_string(i), "application/octet-stream")
                    ->status == 202);
    auto admin = server.adminClient();
    CHECK(admin.Get("/livez")->status == 200);
    CHECK(admin.Get("/readyz")->status == 200);
    CHECK(client.Get("/v1/limits")->status == 200);
}

TEST_SUITE_END();
