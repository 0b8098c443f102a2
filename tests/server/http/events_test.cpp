#include <doctest/doctest.h>

#include <thread>
#include <vector>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBytes = "application/octet-stream";

std::string submit(httplib::Client& client, const std::string& target, const std::string& grid) {
    const auto accepted = client.Post(target, grid, kBytes);
    REQUIRE(accepted);
    REQUIRE(accepted->status == 202);
    return accepted->get_header_value("Location");
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("events: from the queue to the end, then the stream is over") {
    TestServer server({.workers = 1});
    auto client = server.client();
    const std::string running = submit(client, "/v1/jobs", "slow");
    REQUIRE(server.waitRunning(1));
    const std::string waiting = submit(client, "/v1/jobs", "slow 2");
    std::thread opener([&] {
        std::this_thread::sleep_for(150ms);
        server.gate.open = true;
    });
    const auto stream = client.Get(waiting + "/events");
    opener.join();
    REQUIRE(stream);
    CHECK(stream->status == 200);
    CHECK(stream->get_header_value("Content-Type") == "text/event-stream");
    CHECK(stream->get_header_value("Cache-Control") == "no-store");
    const std::string& text = stream->body;
    CHECK(text.starts_with("retry: 1000\n\nid: 1\nevent: progress\ndata: {\"state\":\"queued\""));
    CHECK(text.find("\"queue_position\":0") != std::string::npos);
    CHECK(text.find("\"state\":\"running\"") != std::string::npos);
    CHECK(count(text, "event: done\n") == 1);
    const std::string done = text.substr(text.find("event: done\ndata: ") + 18);
    const auto job = proto::readJson(done, "");
    REQUIRE(job);
    CHECK((*job)["state"] == "succeeded");
}

TEST_CASE("events: a client that comes back gets what it has missed, and no more") {
    const TestServer server;
    auto client = server.client();
    const std::string path = submit(client, "/v1/jobs", "ok");
    const std::string all = client.Get(path + "/events")->body;
    const std::size_t events = count(all, "\nevent: ");
    REQUIRE(events >= 3);
    const auto rest = client.Get(path + "/events", httplib::Headers{{"Last-Event-ID", "2"}});
    CHECK(count(rest->body, "\nevent: ") == events - 2);
    CHECK(rest->body.find("id: 3\n") != std::string::npos);
    CHECK(client.Get(path + "/events?after=2")->body == rest->body);
    for (const char* bad : {"x", "-1", "1.5", "99999999999999999999"})
        checkProblem(client.Get(path + "/events", httplib::Headers{{"Last-Event-ID", bad}}), 400,
                     "malformed-request");
    checkProblem(client.Get(path + "/events?before=1"), 400, "malformed-request");
}

TEST_CASE("events: more followers than there are places are refused") {
    TestServer server;
    server.service->streams = 0;
    auto client = server.client();
    const auto refused = client.Get(submit(client, "/v1/jobs", "ok") + "/events");
    checkProblem(refused, 503, "queue-full");
    CHECK(bodyOf(refused)["setting"] == "--streams");
    CHECK(server.service->streaming == 0);
}

TEST_CASE("idempotency: the same request finds its job, another one is refused") {
    const TestServer server;
    auto client = server.client();
    const httplib::Headers key{{"Idempotency-Key", "\"k\""}};
    const auto first = client.Post("/v1/jobs?alpha=0.5", key, "ok", kBytes);
    const auto again = client.Post("/v1/jobs?alpha=0.5", key, "ok", kBytes);
    REQUIRE(again);
    CHECK(again->status == 202);
    CHECK(again->get_header_value("Location") == first->get_header_value("Location"));
    CHECK(again->get_header_value("Idempotent-Replayed") == "true");
    CHECK_FALSE(first->has_header("Idempotent-Replayed"));
    const auto answered = client.Post("/v1/regularize?alpha=0.5", key, "ok", kBytes);
    CHECK(answered->body == "asset of ok");
    CHECK(answered->get_header_value("Rivage-Job") == first->get_header_value("Rivage-Job"));
    checkProblem(client.Post("/v1/jobs?alpha=0.6", key, "ok", kBytes), 422, "idempotency-mismatch");
    checkProblem(client.Post("/v1/jobs?alpha=0.5", key, "no", kBytes), 422, "idempotency-mismatch");
    checkProblem(client.Post("/v1/jobs", {{"Idempotency-Key", "a b"}}, "ok", kBytes), 400,
                 "malformed-request");
    CHECK(server.gate.started == 1);
}

TEST_CASE("cache: what is said about where an answer comes from") {
    TestServer server;
    auto client = server.client();
    const auto status = [&](const httplib::Headers& headers = {}) {
        return client.Post("/v1/regularize", headers, "ok", kBytes)
            ->get_header_value("Cache-Status");
    };
    CHECK(status() == "rivage; fwd=miss");
    CHECK(status() == "rivage; hit");
    CHECK(status({{"Cache-Control", "no-cache"}}) == "rivage; fwd=request");
    CHECK(server.gate.started == 2);
}

TEST_CASE("single flight: a hundred identical posts run one job") {
    TestServer server({.workers = 2, .queueLimit = 200});
    std::atomic<int> right{0};
    std::vector<std::thread> clients;
    for (int i = 0; i < 100; ++i)
        clients.emplace_back([&] {
            auto client = server.client();
            const auto result = client.Post("/v1/regularize", "slow", kBytes);
            if (result && result->status == 200 && result->body == "asset of slow") ++right;
        });
    while (server.pool->stats().unfinished < 100) std::this_thread::sleep_for(1ms);
    server.gate.open = true;
    for (std::thread& client : clients) client.join();
    CHECK(right == 100);
    CHECK(server.gate.started == 1);
}

TEST_CASE("results: digests of whole answers, at most 16 ranges") {
    const TestServer server;
    auto client = server.client();
    const std::string path = submit(client, "/v1/jobs", "ok");
    (void)client.Get(path, httplib::Headers{{"Prefer", "wait=10"}});
    const auto whole = client.Get(path + "/result");
    CHECK(whole->get_header_value("Content-Digest") == whole->get_header_value("Repr-Digest"));
    const auto part = client.Get(path + "/result", httplib::Headers{{"Range", "bytes=0-1"}});
    CHECK(part->status == 206);
    CHECK_FALSE(part->has_header("Content-Digest"));
    std::string ranges = "bytes=0-0";
    for (int i = 0; i < 16; ++i) ranges += "," + std::to_string(i % 11) + "-";
    checkProblem(client.Get(path + "/result", httplib::Headers{{"Range", ranges}}), 416,
                 "range-not-satisfiable");
}

TEST_SUITE_END();
