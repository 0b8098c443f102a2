#include <doctest/doctest.h>

#include <atomic>
#include <thread>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

namespace {

constexpr const char* kBytes = "application/octet-stream";

/// Posts a body that never ends. @return the answer, and how many bytes the server took
httplib::Result postEndless(httplib::Client& client, std::atomic<std::size_t>& taken) {
    return client.Post(
        "/v1/regularize", 1 << 20,
        [&](std::size_t, std::size_t, httplib::DataSink& sink) {
            const std::string piece(1024, 'x');
            if (!sink.write(piece.data(), piece.size())) return false;
            taken += piece.size();
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            return true;
        },
        kBytes);
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("admission: a full server refuses before it has read the body") {
    TestServer server({.workers = 1, .queueLimit = 0});
    auto client = server.client();
    const auto running = client.Post("/v1/jobs", "slow", kBytes);
    REQUIRE(running);
    REQUIRE(running->status == 202);
    checkProblem(client.Post("/v1/regularize", "ok", kBytes), 503, "queue-full");
    checkProblem(client.Post("/v1/jobs", "ok", kBytes), 503, "queue-full");
    checkProblem(client.Post("/v1/inspect", "ok", kBytes), 503, "queue-full");
    const auto before = server::Clock::now();
    const std::string answer =
        server.raw("POST /v1/regularize HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n\r\n");
    CHECK(answer.starts_with("HTTP/1.1 503"));
    CHECK(server::Clock::now() - before < std::chrono::seconds(1));
}

TEST_CASE("admission: Expect: 100-continue is answered with the refusal, not with 100") {
    TestServer server({.workers = 1, .queueLimit = 0, .maxUpload = 1000});
    const std::string head = "POST /v1/regularize HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\n";
    const std::string tooLong = server.raw(head + "Content-Length: 1001\r\n\r\n");
    CHECK(tooLong.starts_with("HTTP/1.1 413"));
    CHECK(tooLong.find("/problems/too-large") != std::string::npos);
    const std::string welcome =
        server.raw(head + "Connection: close\r\nContent-Length: 2\r\n\r\nok");
    CHECK(welcome.starts_with("HTTP/1.1 100"));
    CHECK(welcome.find("HTTP/1.1 200") != std::string::npos);

    auto client = server.client();
    REQUIRE(client.Post("/v1/jobs", "slow", kBytes)->status == 202);
    const std::string full = server.raw(head + "Content-Length: 2\r\n\r\n");
    CHECK(full.starts_with("HTTP/1.1 503"));
    CHECK(full.find("HTTP/1.1 100") == std::string::npos);
}

TEST_CASE("admission: an upload holds a place, and gives it back when it fails") {
    TestServer server({.workers = 1, .queueLimit = 0, .maxUpload = 2 << 20});
    std::atomic<std::size_t> taken{0};
    auto uploader = server.client();
    std::thread upload([&] { (void)postEndless(uploader, taken); });
    while (taken < 2048) std::this_thread::yield();
    auto client = server.client();
    checkProblem(client.Post("/v1/regularize", "ok", kBytes), 503, "queue-full");
    uploader.stop();
    upload.join();
    for (int i = 0; i < 5000 && !server.pool->idle(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    CHECK(client.Post("/v1/regularize", "ok", kBytes)->status == 200);
}

TEST_CASE("admission: a refused request gives its place back before its answer is seen") {
    TestServer server({.workers = 1, .queueLimit = 0});
    auto client = server.client();
    for (int i = 0; i < 100; ++i)
        checkProblem(client.Post("/v1/regularize?x=1", "ok", kBytes), 400, "unknown-option");
    for (int i = 0; i < 100; ++i)
        REQUIRE(client.Post("/v1/regularize", "ok", kBytes)->status == 200);
}

TEST_SUITE_END();
