#include <doctest/doctest.h>

#include <thread>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;

namespace {

/// Submits a job. @return its path
std::string submit(httplib::Client& client, const std::string& grid) {
    const auto accepted = client.Post("/v1/jobs", grid, "application/octet-stream");
    REQUIRE(accepted);
    REQUIRE(accepted->status == 202);
    CHECK_FALSE(accepted->get_header_value("Retry-After").empty());
    const std::string path = accepted->get_header_value("Location");
    CHECK(bodyOf(accepted)["links"]["self"] == path);
    return path;
}

proto::Json waitFor(httplib::Client& client, const std::string& path) {
    return bodyOf(client.Get(path, httplib::Headers{{"Prefer", "wait=10"}}));
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("jobs: accepted, followed, fetched, forgotten") {
    const TestServer server;
    auto client = server.client();
    const std::string path = submit(client, "ok");
    const auto job = waitFor(client, path);
    CHECK(job["state"] == "succeeded");
    CHECK(job["progress"] == 1);
    CHECK(job["attempt"] == 1);
    CHECK(job["expires_at"].is_string());
    CHECK(job["links"]["result"] == path + "/result");

    const auto result = client.Get(path + "/result");
    REQUIRE(result);
    CHECK(result->status == 200);
    CHECK(result->body == "asset of ok");
    CHECK(client.Delete(path)->status == 204);
    checkProblem(client.Get(path), 404, "not-found");
    checkProblem(client.Get(path + "/result"), 404, "not-found");
    checkProblem(client.Delete(path), 404, "not-found");
}

TEST_CASE("jobs: state, place and result while it waits and runs") {
    TestServer server({.workers = 1, .queueLimit = 8});
    auto client = server.client();
    const std::string running = submit(client, "slow");
    REQUIRE(server.waitRunning(1));
    const std::string waiting = submit(client, "slow 2");
    CHECK(bodyOf(client.Get(running))["state"] == "running");
    CHECK(bodyOf(client.Get(running))["queue_position"].is_null());
    CHECK(bodyOf(client.Get(waiting))["state"] == "queued");
    CHECK(bodyOf(client.Get(waiting))["queue_position"] == 0);
    const auto early = client.Get(running + "/result");
    REQUIRE(early);
    CHECK(early->status == 202);
    CHECK_FALSE(early->get_header_value("Retry-After").empty());
    server.gate.open = true;
    CHECK(waitFor(client, waiting)["state"] == "succeeded");
}

TEST_CASE("jobs: DELETE cancels what waits and what runs; its result is the problem canceled") {
    const TestServer server({.workers = 1, .queueLimit = 8});
    auto client = server.client();
    const std::string running = submit(client, "slow");
    const std::string waiting = submit(client, "slow 2");
    REQUIRE(server.waitRunning(1));
    CHECK(client.Delete(waiting)->status == 204);
    CHECK(client.Delete(running)->status == 204);
    for (const std::string& path : {waiting, running}) {
        const auto job = waitFor(client, path);
        CHECK(job["state"] == "canceled");
        CHECK(job["error"]["type"] == "/problems/canceled");
        checkProblem(client.Get(path + "/result"), 409, "canceled");
    }
}

TEST_CASE("jobs: the result of a failed job is its problem") {
    const TestServer server;
    auto client = server.client();
    const std::string path = submit(client, "empty");
    CHECK(waitFor(client, path)["state"] == "failed");
    const auto result = client.Get(path + "/result");
    checkProblem(result, 422, "empty-grid");
    CHECK(bodyOf(result)["instance"] == path);
}

TEST_CASE("jobs: after their time they have expired") {
    const TestServer server({.store = {.resultTtl = 0s}});
    auto client = server.client();
    const std::string path = submit(client, "ok");
    for (int i = 0; i < 500 && client.Get(path)->status == 200; ++i)
        std::this_thread::sleep_for(10ms);
    checkProblem(client.Get(path), 410, "result-expired");
    checkProblem(client.Get(path + "/result"), 410, "result-expired");
}

TEST_CASE("jobs: a result that made room for others is gone, its job is not") {
    const TestServer server({.store = {.resultBytes = 15}});
    auto client = server.client();
    const std::string first = submit(client, "ok1");
    waitFor(client, first);
    waitFor(client, submit(client, "ok2"));
    CHECK(bodyOf(client.Get(first))["state"] == "succeeded");
    checkProblem(client.Get(first + "/result"), 410, "result-expired");
}

TEST_CASE("jobs: entity tags, ranges and HEAD on results") {
    const TestServer server;
    auto client = server.client();
    const std::string path = submit(client, "ok");
    waitFor(client, path);
    const std::string result = path + "/result";
    const auto head = client.Head(result);
    REQUIRE(head);
    CHECK(head->status == 200);
    CHECK(head->body.empty());
    CHECK(head->get_header_value("Content-Length") == "11");
    const std::string etag = head->get_header_value("ETag");

    for (const std::string& tags : {etag, "\"x\", " + etag, "W/" + etag, std::string("*")}) {
        CAPTURE(tags);
        const auto same = client.Get(result, httplib::Headers{{"If-None-Match", tags}});
        REQUIRE(same);
        CHECK(same->status == 304);
        CHECK(same->body.empty());
        CHECK(same->get_header_value("ETag") == etag);
    }
    CHECK(client.Get(result, httplib::Headers{{"If-None-Match", "\"x\""}})->status == 200);

    const auto part = client.Get(result, httplib::Headers{{"Range", "bytes=0-4"}});
    REQUIRE(part);
    CHECK(part->status == 206);
    CHECK(part->body == "asset");
    CHECK(part->get_header_value("Content-Range") == "bytes 0-4/11");
    CHECK(
        client.Get(result, httplib::Headers{{"Range", "bytes=0-4"}, {"If-Range", etag}})->status ==
        206);
    CHECK(client.Get(result, httplib::Headers{{"Range", "bytes=0-4"}, {"If-Range", "\"x\""}})
              ->status == 200);
    checkProblem(client.Get(result, httplib::Headers{{"Range", "bytes=99-"}}), 416,
                 "range-not-satisfiable");
}

TEST_CASE("jobs: the list is newest first, by state, in pages") {
    const TestServer server;
    auto client = server.client();
    std::vector<std::string> paths;
    for (const char* grid : {"ok", "empty", "ok 2"}) {
        paths.push_back(submit(client, grid));
        waitFor(client, paths.back());
    }
    const auto all = bodyOf(client.Get("/v1/jobs"));
    REQUIRE(all["jobs"].size() == 3);
    CHECK(all["next"].is_null());
    for (std::size_t i = 0; i < 3; ++i) CHECK(all["jobs"][i]["links"]["self"] == paths[2 - i]);
    CHECK(bodyOf(client.Get("/v1/jobs?state=failed"))["jobs"].size() == 1);
    const auto page = bodyOf(client.Get("/v1/jobs?limit=2"));
    CHECK(page["jobs"].size() == 2);
    const auto rest = bodyOf(client.Get(page["next"].get<std::string>()));
    CHECK(rest["jobs"].size() == 1);
    for (const char* bad :
         {"?limit=0", "?limit=501", "?limit=x", "?state=done", "?colour=1", "?limit=1&limit=2"})
        checkProblem(client.Get(std::string("/v1/jobs") + bad), 400, "malformed-request");
}

TEST_CASE("reject: ids that are none, and ids that nobody has") {
    const TestServer server;
    auto client = server.client();
    for (const char* path : {"/v1/jobs/x", "/v1/jobs/01234567-89ab-7def-8123-456789abcdef",
                             "/v1/jobs/%2e%2e", "/v1/jobs/x/result"}) {
        checkProblem(client.Get(path), 404, "not-found");
    }
}

TEST_CASE("jobs: more waiting clients than the limit are answered at once") {
    TestServer server({.workers = 1});
    server.service->longPolls = 0;
    auto client = server.client();
    const std::string path = submit(client, "slow");
    const auto before = server::Clock::now();
    CHECK(bodyOf(client.Get(path, httplib::Headers{{"Prefer", "wait=10"}}))["state"] !=
          "succeeded");
    CHECK(server::Clock::now() - before < 2s);
}

TEST_SUITE_END();
