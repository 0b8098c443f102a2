#include <doctest/doctest.h>

#include <thread>

#include "server/jobs/digest.h"
#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBytes = "application/octet-stream";
constexpr const char* kRoute = "/v1/regularize";

httplib::UploadFormDataItems form(const std::string& grid, const std::string& options) {
    httplib::UploadFormDataItems items{{"grid", grid, "My Island.vox", kBytes}};
    if (!options.empty()) items.push_back({"options", options, "", "application/json"});
    return items;
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("regularize: a raw body gives the artifact and all that is said about it") {
    const TestServer server;
    auto client = server.client();
    const auto result = client.Post("/v1/regularize?alpha=0.5&output=glb", "ok", kBytes);
    REQUIRE(result);
    CHECK(result->status == 200);
    CHECK(result->body == "asset of ok");
    CHECK(result->get_header_value("Content-Type") == "model/gltf-binary");
    CHECK(result->get_header_value("Content-Disposition") == "attachment; filename=\"rivage.glb\"");
    const std::string timing = result->get_header_value("Server-Timing");
    for (const char* stage : {"queue", "parse", "surface", "normals", "solve", "mesh", "write"})
        CHECK(timing.find(std::string(stage) + ";dur=") != std::string::npos);
    const auto* bytes = reinterpret_cast<const std::byte*>(result->body.data());
    CHECK(result->get_header_value("ETag") ==
          '"' + server::sha256({bytes, result->body.size()}).hex + '"');
    CHECK(result->get_header_value("Repr-Digest").starts_with("sha-256=:"));

    const auto job = bodyOf(client.Get("/v1/jobs/" + result->get_header_value("Rivage-Job")));
    CHECK(job["state"] == "succeeded");
    CHECK(job["options"]["alpha"] == 0.5);
    CHECK(job["report"].is_object());
}

TEST_CASE("regularize: a raw body is named by Content-Disposition, safely") {
    const TestServer server;
    auto client = server.client();
    const auto named = [&](const std::string& disposition) {
        const httplib::Headers headers{{"Content-Disposition", disposition},
                                       {"Cache-Control", "no-cache"}};
        const auto result = client.Post(kRoute, headers, "ok", kBytes);
        REQUIRE(result);
        CHECK(result->status == 200);
        const auto job = bodyOf(client.Get("/v1/jobs/" + result->get_header_value("Rivage-Job")));
        const std::string name = job["name"];
        CHECK(result->get_header_value("Content-Disposition") ==
              "attachment; filename=\"" + name + ".glb\"");
        return name;
    };
    CHECK(named("attachment; filename=\"house.vox\"") == "house");
    CHECK(named("inline;FILENAME=house.v2.vox") == "house_v2");
    CHECK(named("attachment; filename=\"../../a b\\\".vox\"") == "a_b_");
    CHECK(named("attachment; filename=\"" + std::string(300, 'x') + "\"") == std::string(64, 'x'));
    for (const char* nameless : {"attachment", ";", "attachment; filename=\"", "filename=x.vox",
                                 "attachment; filename=\".vox\"", "attachment; filename=\"a/\""})
        CHECK(named(nameless) == "rivage");
}

TEST_CASE("regularize: a form with grid and options, names from the file") {
    const TestServer server;
    auto client = server.client();
    const auto result = client.Post(kRoute, form("ok", R"({"alpha":0.25})"));
    REQUIRE(result);
    CHECK(result->status == 200);
    CHECK(result->body == "asset of ok");
    CHECK(result->get_header_value("Content-Disposition") ==
          "attachment; filename=\"My_Island.glb\"");
    const auto job = bodyOf(client.Get("/v1/jobs/" + result->get_header_value("Rivage-Job")));
    CHECK(job["options"]["alpha"] == 0.25);
    CHECK(job["name"] == "My_Island");
    CHECK(client.Post(kRoute, form("ok", ""))->status == 200);
}

TEST_CASE("reject: forms that are no forms of ours") {
    const TestServer server;
    auto client = server.client();
    checkProblem(client.Post("/v1/regularize?alpha=1", form("ok", R"({"alpha":1})")), 400,
                 "invalid-option");
    checkProblem(client.Post(kRoute, form("ok", "{")), 400, "malformed-request");
    checkProblem(client.Post(kRoute, form("ok", std::string(70000, ' '))), 400,
                 "malformed-request");
    httplib::UploadFormDataItems items = form("ok", "");
    items.push_back({"grid", "again", "b.vox", kBytes});
    checkProblem(client.Post(kRoute, items), 400, "malformed-request");
    checkProblem(client.Post(kRoute, httplib::UploadFormDataItems{{"file", "ok", "a", kBytes}}),
                 400, "malformed-request");
    checkProblem(client.Post(kRoute, httplib::UploadFormDataItems{{"options", "{}", "", ""}}), 400,
                 "malformed-request");
    checkProblem(client.Post(kRoute, "no form", "multipart/form-data; boundary=x"), 400,
                 "malformed-request");
    checkProblem(client.Post(kRoute, "no form", "multipart/form-data"), 400, "malformed-request");
}

TEST_CASE("reject: options are refused before the job exists") {
    const TestServer server;
    auto client = server.client();
    checkProblem(client.Post("/v1/regularize?alhpa=1", "ok", kBytes), 400, "unknown-option");
    checkProblem(client.Post("/v1/regularize?alpha=nan", "ok", kBytes), 400, "invalid-option");
    const auto late = client.Post("/v1/regularize?deadline_ms=99999", "ok", kBytes);
    checkProblem(late, 400, "invalid-option");
    CHECK(bodyOf(late)["setting"] == "--deadline");
    CHECK(bodyOf(client.Get("/v1/jobs"))["jobs"].empty());
}

TEST_CASE("reject: what the engine refuses has its own problem, and names the job") {
    const TestServer server;
    auto client = server.client();
    checkProblem(client.Post(kRoute, "bad", kBytes), 400, "malformed-input");
    checkProblem(client.Post(kRoute, "odd", kBytes), 415, "unsupported-format");
    checkProblem(client.Post(kRoute, "memory", kBytes), 422, "memory-budget");
    checkProblem(client.Post(kRoute, "throw", kBytes), 500, "internal");
    const auto empty = client.Post(kRoute, "empty", kBytes);
    checkProblem(empty, 422, "empty-grid");
    CHECK(bodyOf(empty)["instance"] == "/v1/jobs/" + empty->get_header_value("Rivage-Job"));
    const auto big = client.Post(kRoute, "big", kBytes);
    checkProblem(big, 413, "too-large");
    CHECK(bodyOf(big)["limit"] == 5);
    CHECK(bodyOf(big)["actual"] == 6);
    CHECK(bodyOf(big)["setting"] == "--max");
    checkProblem(client.Post("/v1/regularize?deadline_ms=30", "slow", kBytes), 504,
                 "deadline-exceeded");
    checkProblem(client.Post(kRoute, "", kBytes), 400, "malformed-request");
}

TEST_CASE("regularize: Prefer decides how long the answer may take") {
    TestServer server;
    auto client = server.client();
    const auto async = client.Post(kRoute, {{"Prefer", "respond-async"}}, "slow", kBytes);
    REQUIRE(async);
    CHECK(async->status == 202);
    CHECK(async->get_header_value("Preference-Applied") == "respond-async");
    CHECK(async->get_header_value("Location") ==
          "/v1/jobs/" + async->get_header_value("Rivage-Job"));
    CHECK_FALSE(async->get_header_value("Retry-After").empty());

    const auto waited = client.Post(kRoute, {{"Prefer", "wait=1"}}, "slow", kBytes);
    REQUIRE(waited);
    CHECK(waited->status == 202);
    CHECK(waited->get_header_value("Preference-Applied") == "wait=1");
    CHECK(client.Post(kRoute, {{"Prefer", "wait=0"}}, "slow", kBytes)->status == 202);

    server.gate.open = true;
    const auto quick = client.Post(kRoute, {{"Prefer", "wait=10"}}, "ok", kBytes);
    REQUIRE(quick);
    CHECK(quick->status == 200);
}

TEST_CASE("regularize: a client that leaves frees its worker within 250 ms") {
    const TestServer server({.workers = 1, .queueLimit = 4});
    auto impatient = server.client();
    impatient.set_read_timeout(200ms);
    std::thread leaver([&] { CHECK_FALSE(impatient.Post(kRoute, "slow", kBytes)); });
    REQUIRE(server.waitRunning(1));
    leaver.join();
    const auto left = server::Clock::now();
    REQUIRE(server.waitRunning(0));
    CHECK(server::Clock::now() - left < 250ms);
    auto client = server.client();
    CHECK(client.Post(kRoute, "ok", kBytes)->status == 200);
    const auto jobs = bodyOf(client.Get("/v1/jobs?state=canceled"))["jobs"];
    CHECK(jobs.size() == 1);
}

TEST_CASE("regularize: cancelled from elsewhere, the waiting client is told") {
    const TestServer server;
    auto client = server.client();
    std::thread canceller([&] {
        CHECK(server.waitRunning(1));
        auto other = server.client();
        const auto jobs = other.Get("/v1/jobs");
        const std::string id = proto::readJson(jobs->body, "")->at("jobs")[0]["id"];
        CHECK(other.Delete("/v1/jobs/" + id)->status == 204);
    });
    checkProblem(client.Post(kRoute, "slow", kBytes), 409, "canceled");
    canceller.join();
}

TEST_CASE("inspect: the engine's answer, or the problem that the job would get") {
    const TestServer server;
    auto client = server.client();
    const auto result = client.Post("/v1/inspect", "ok", kBytes);
    REQUIRE(result);
    CHECK(result->status == 200);
    CHECK(result->get_header_value("Content-Type") == "application/json");
    CHECK(result->get_header_value("Rivage-Job").empty());
    checkProblem(client.Post("/v1/inspect", "empty", kBytes), 422, "empty-grid");
    checkProblem(client.Post("/v1/inspect?nothing=1", "ok", kBytes), 400, "unknown-option");
    CHECK(bodyOf(client.Get("/v1/jobs"))["jobs"].empty());
}

TEST_SUITE_END();
