#include <doctest/doctest.h>

#include <array>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

TEST_SUITE_BEGIN("server/http");

TEST_CASE("info: limits, formats, options, samples and version") {
    const TestServer server({.maxUpload = 12345});
    auto client = server.client();
    CHECK(bodyOf(client.Get("/v1/limits"))["upload_bytes"] == 12345);
    CHECK(bodyOf(client.Get("/v1/formats"))["output"][0]["name"] == "glb");
    CHECK(bodyOf(client.Get("/v1/options"))["options"].size() > 20);
    CHECK(bodyOf(client.Get("/version"))["name"] == "rivage");
    CHECK(bodyOf(client.Get("/v1/samples"))["samples"][0]["href"] == "/v1/samples/dot");
    const auto sample = client.Get("/v1/samples/dot");
    REQUIRE(sample);
    CHECK(sample->status == 200);
    CHECK(sample->body == "vvv");
    CHECK(sample->get_header_value("Content-Disposition") == "attachment; filename=\"dot.vox\"");
    checkProblem(client.Get("/v1/samples/none"), 404, "not-found");
    CHECK(client.Head("/v1/options")->status == 200);
}

TEST_CASE("info: the schema is served as JSON, with an entity tag") {
    const TestServer server;
    auto client = server.client();
    const auto schema = client.Get("/openapi.json");
    CHECK(bodyOf(schema)["openapi"].get<std::string>().starts_with("3.1"));
    CHECK(schema->get_header_value("Content-Type") == "application/json");
    const std::string etag = schema->get_header_value("ETag");
    const auto same = client.Get("/openapi.json", httplib::Headers{{"If-None-Match", etag}});
    REQUIRE(same);
    CHECK(same->status == 304);
}

TEST_CASE("info: the viewer's files, or a list of routes without them") {
    TestServer server;
    auto client = server.client();
    CHECK(bodyOf(client.Get("/"))["routes"].size() > 10);

    constexpr std::array<std::byte, 2> bytes{std::byte{'h'}, std::byte{'i'}};
    const std::array<server::WebAsset, 2> assets{{
        {"/index.html", "text/html", bytes, "\"1\""},
        {"/draco/x.wasm", "application/wasm", bytes, "\"2\""},
    }};
    server.service->assets = assets;
    for (const char* path : {"/", "/index.html", "/draco/x.wasm"}) {
        const auto file = client.Get(path);
        REQUIRE(file);
        CHECK(file->status == 200);
        CHECK(file->body == "hi");
    }
    CHECK(client.Get("/draco/x.wasm")->get_header_value("Content-Type") == "application/wasm");
    CHECK(client.Get("/", httplib::Headers{{"If-None-Match", "\"1\""}})->status == 304);
    checkProblem(client.Post("/draco/x.wasm", "", "text/plain"), 405, "method-not-allowed");
    checkProblem(client.Get("/draco/"), 404, "not-found");
}

TEST_CASE("info: /metrics counts what has happened; the admin port has nothing else") {
    const TestServer server;
    auto client = server.client();
    for (const char* grid : {"ok", "ok 2", "empty"})
        REQUIRE(client.Post("/v1/regularize", grid, "application/octet-stream"));
    auto admin = server.adminClient();
    const auto metrics = admin.Get("/metrics");
    REQUIRE(metrics);
    CHECK(metrics->get_header_value("Content-Type").starts_with("text/plain; version=0.0.4"));
    for (const char* line :
         {"rivage_jobs_total{outcome=\"succeeded\",reason=\"\"} 2\n",
          "rivage_jobs_total{outcome=\"failed\",reason=\"empty-grid\"} 1\n",
          "rivage_queue_depth 0\n", "rivage_workers 2\n", "# TYPE rivage_jobs_total counter\n",
          "rivage_job_stage_duration_seconds_count{stage=\"parse\"} 3\n",
          "process_resident_memory_bytes "})
        CHECK(metrics->body.find(line) != std::string::npos);
    checkProblem(admin.Get("/v1/jobs"), 404, "not-found");
    checkProblem(client.Get("/metrics"), 404, "not-found");
}

TEST_CASE("info: every request is observed once") {
    const TestServer server;
    auto client = server.client();
    for (int i = 0; i < 3; ++i) (void)client.Get("/version");
    (void)client.Get("/nothing");
    CHECK(server.records == 4);
}

TEST_SUITE_END();
