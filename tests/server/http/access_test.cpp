#include "server/http/access.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

namespace {

constexpr const char* kBytes = "application/octet-stream";

std::string secret(const std::string& name) { return "the-key-of-" + name + "-0123456789"; }

std::string line(const std::string& name, const std::string& attributes = {}) {
    return server::keyLine(name, secret(name)).value() + attributes + "\n";
}

httplib::Headers as(const std::string& name) {
    return {{"Authorization", "Bearer " + secret(name)}};
}

/// All routes and paths that need a key, with ids that exist nowhere.
const char* const kPrivate[] = {"/v1/jobs", "/v1/limits", "/v1/nothing", "/v1/",
                                "/v1/jobs/00000000-0000-7000-8000-000000000000"};

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("access: 401 on all of /v1 without a known key, whatever is there") {
    const TestServer server({.keys = line("anna")});
    auto client = server.client();
    const httplib::Headers wrong[] = {
        {},
        {{"Authorization", "Bearer wrong"}},
        {{"Authorization", secret("anna")}},
        {{"Authorization", "Basic " + secret("anna")}},
        {{"Authorization", "Bearer"}},
        {{"X-API-Key", secret("bob")}},
        {{"X-API-Key", secret("anna")}, {"Authorization", "Bearer " + secret("anna")}},
    };
    for (const char* path : kPrivate)
        for (const httplib::Headers& headers : wrong) {
            const auto answer = client.Get(path, headers);
            checkProblem(answer, 401, "unauthorized");
            CHECK(answer->get_header_value("WWW-Authenticate") == "Bearer realm=\"rivage\"");
        }
    checkProblem(client.Delete("/v1/limits"), 401, "unauthorized");
    for (const char* path : {"/version", "/openapi.json", "/"})
        CHECK(client.Get(path)->status == 200);
    checkProblem(client.Get("/nothing"), 404, "not-found");
}

TEST_CASE("access: both headers let the holder in") {
    const TestServer server({.keys = line("anna")});
    auto client = server.client();
    CHECK(client.Get("/v1/limits", as("anna"))->status == 200);
    CHECK(
        client.Get("/v1/limits", httplib::Headers{{"Authorization", "bearer   " + secret("anna")}})
            ->status == 200);
    CHECK(client.Get("/v1/limits", httplib::Headers{{"X-API-Key", secret("anna")}})->status == 200);
}

TEST_CASE("access: switched off and expired keys are 403") {
    const TestServer server(
        {.keys = line("off", " disabled") + line("old", " expires=2020-01-01")});
    auto client = server.client();
    for (const char* name : {"off", "old"})
        checkProblem(client.Get("/v1/limits", as(name)), 403, "forbidden");
}

TEST_CASE("access: refused before the body is read, also with Expect: 100-continue") {
    const TestServer server({.keys = line("anna", " rate=1/h") + line("off", " disabled")});
    const std::string head = "POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Length: 1000000\r\n";
    const std::string expect = "Expect: 100-continue\r\n";
    for (const std::string& more : {std::string(), expect}) {
        const std::string answer = server.raw(head + more + "\r\n");
        CHECK(answer.starts_with("HTTP/1.1 401"));
        CHECK(answer.find("HTTP/1.1 100") == std::string::npos);
        CHECK(server.raw(head + more + "X-API-Key: " + secret("off") + "\r\n\r\n")
                  .starts_with("HTTP/1.1 403"));
    }
    CHECK(server.gate.started == 0);
}

TEST_CASE("access: a request counts once, also where Expect asks twice") {
    const TestServer server({.keys = line("anna", " rate=2/h")});
    const std::string head =
        "POST /v1/regularize HTTP/1.1\r\nHost: x\r\nConnection: close\r\n"
        "Expect: 100-continue\r\nContent-Length: 2\r\nX-API-Key: " +
        secret("anna") + "\r\n\r\n";
    for (int i = 0; i < 2; ++i)
        CHECK(server.raw(head + "ok").find("HTTP/1.1 200") != std::string::npos);
    CHECK(server.raw(head).starts_with("HTTP/1.1 429"));
}

TEST_CASE("access: 429 says how many requests, in how long, and when the next is granted") {
    const TestServer server({.keys = line("anna", " rate=2/m") + line("bob")});
    auto client = server.client();
    for (int i = 0; i < 2; ++i) CHECK(client.Get("/v1/limits", as("anna"))->status == 200);
    const auto answer = client.Get("/v1/limits", as("anna"));
    checkProblem(answer, 429, "quota-exceeded");
    CHECK(answer->get_header_value("RateLimit-Policy") == "\"requests\";q=2;w=60");
    const std::string wait = answer->get_header_value("Retry-After");
    CHECK(answer->get_header_value("RateLimit") == "\"requests\";r=0;t=" + wait);
    CHECK(std::stoi(wait) >= 1);
    CHECK(std::stoi(wait) <= 30);
    CHECK(bodyOf(answer)["limit"] == 2);
    CHECK(client.Get("/v1/limits", as("bob"))->status == 200);
}

TEST_CASE("access: no more unfinished jobs than the key may have") {
    TestServer server({.workers = 4, .keys = line("anna", " jobs=2") + line("bob", " jobs=1")});
    auto client = server.client();
    for (int i = 0; i < 2; ++i)
        REQUIRE(client.Post("/v1/jobs", as("anna"), "slow", kBytes)->status == 202);
    const auto answer = client.Post("/v1/jobs", as("anna"), "slow", kBytes);
    checkProblem(answer, 429, "quota-exceeded");
    CHECK(answer->get_header_value("RateLimit-Policy") == "\"jobs\";q=2");
    CHECK(answer->get_header_value("RateLimit") == "\"jobs\";r=0");
    CHECK_FALSE(answer->get_header_value("Retry-After").empty());
    CHECK(client.Get("/v1/jobs", as("anna"))->status == 200);
    CHECK(client.Post("/v1/regularize", as("bob"), "ok", kBytes)->status == 200);
    server.gate.open = true;
    for (int i = 0; i < 5000 && !server.pool->idle(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    for (int i = 0; i < 20; ++i) {
        CHECK(client.Post("/v1/regularize", as("anna"), "ok", kBytes)->status == 200);
        CHECK(client.Post("/v1/regularize?x=1", as("anna"), "ok", kBytes)->status == 400);
    }
}

TEST_CASE("access: jobs of other keys are 404, and not in the list") {
    const TestServer server({.keys = line("anna") + line("bob")});
    auto client = server.client();
    const auto posted = client.Post("/v1/jobs", as("anna"), "ok", kBytes);
    REQUIRE(posted);
    const std::string job = posted->get_header_value("Location");
    CHECK(client.Get(job, as("anna"))->status == 200);
    for (const std::string& path : {job, job + "/result"})
        checkProblem(client.Get(path, as("bob")), 404, "not-found");
    checkProblem(client.Delete(job, as("bob")), 404, "not-found");
    CHECK(bodyOf(client.Get("/v1/jobs", as("bob")))["jobs"].empty());
    CHECK(bodyOf(client.Get("/v1/jobs", as("anna")))["jobs"].size() == 1);
}

TEST_CASE("access: a new file takes effect, a broken one does not") {
    const TestServer server({.keys = line("anna")});
    auto client = server.client();
    const auto path = std::filesystem::temp_directory_path() / "rivage-reload-test.keys";
    std::ofstream(path) << "broken\n";
    const auto broken = server.service->access->reload(path.string());
    REQUIRE_FALSE(broken);
    CHECK(broken.error().message.find("line 1") != std::string::npos);
    CHECK(client.Get("/v1/limits", as("anna"))->status == 200);
    std::ofstream(path) << line("bob");
    CHECK(server.service->access->reload(path.string()));
    CHECK(client.Get("/v1/limits", as("anna"))->status == 401);
    CHECK(client.Get("/v1/limits", as("bob"))->status == 200);
    std::filesystem::remove(path);
}

TEST_SUITE_END();
