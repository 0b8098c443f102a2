#include "server/ops/metrics.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

namespace {

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("server/ops");

TEST_CASE("metrics: every name of the interface is there from the start") {
    TestServer server;
    const std::string text = server.metrics.text(*server.service);
    for (const char* name : {"rivage_job_queue_wait_seconds",
                             "rivage_queue_depth",
                             "rivage_queue_capacity",
                             "rivage_workers",
                             "rivage_workers_busy",
                             "rivage_worker_heartbeat_timestamp_seconds",
                             "rivage_admission_rejected_total",
                             "rivage_memory_reserved_bytes",
                             "rivage_memory_budget_bytes",
                             "rivage_cache_requests_total",
                             "rivage_solver_iterations",
                             "rivage_input_voxels",
                             "rivage_output_triangles",
                             "rivage_output_bytes",
                             "rivage_build_info",
                             "rivage_restarts_total",
                             "rivage_jobs_total",
                             "http_server_active_requests",
                             "http_server_open_connections",
                             "process_resident_memory_bytes",
                             "process_virtual_memory_bytes",
                             "process_cpu_seconds_total",
                             "process_open_fds",
                             "process_start_time_seconds",
                             "process_threads"}) {
        CAPTURE(name);
        CHECK(has(text, "# TYPE " + std::string(name) + " "));
    }
    for (const char* reason : {"queue_full", "quota", "memory", "draining"})
        CHECK(has(text, "rivage_admission_rejected_total{reason=\"" + std::string(reason) + "\"}"));
    for (const char* label : {"version=\"", "commit=\"", "httplib=\"0.53", "draco=\"1."})
        CHECK(has(text, label));
}

TEST_CASE("metrics: requests are counted by method, route, status and problem") {
    TestServer server;
    auto client = server.client();
    REQUIRE(client.Post("/v1/regularize", "ok", "application/octet-stream"));
    REQUIRE(client.Post("/v1/regularize", "bad", "application/octet-stream"));
    for (int i = 0; i < 2000 && server.records < 2; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const std::string text = server.metrics.text(*server.service);
    CHECK(has(text,
              "http_server_request_duration_seconds_count{error_type=\"\",http_request_method="
              "\"POST\",http_response_status_code=\"200\",http_route=\"/v1/regularize\"} 1"));
    CHECK(has(text,
              "error_type=\"malformed-input\",http_request_method=\"POST\",http_response_"
              "status_code=\"400\",http_route=\"/v1/regularize\""));
    CHECK(has(text, "le=\"120\""));
    CHECK(has(text, "rivage_output_bytes_count 1\n"));
    CHECK(has(text,
              "http_server_request_body_size_bytes_sum{http_request_method=\"POST\","
              "http_route=\"/v1/regularize\"} 5\n"));
}

TEST_CASE("metrics: no client can add series") {
    TestServer server;
    auto client = server.client();
    const auto lines = [&] {
        const std::string text = server.metrics.text(*server.service);
        return std::count(text.begin(), text.end(), '\n');
    };
    const auto send = [&](int i) {
        const std::string path = "/v1/jobs/" + std::to_string(i);
        (void)client.Get(path);
        (void)client.Get("/nothing/" + std::to_string(i));
        httplib::Headers headers{{"X-Request-ID", std::to_string(i)}};
        (void)client.Get("/version", headers);
    };
    send(0);
    for (int i = 0; i < 2000 && server.records < 3; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto before = lines();
    for (int i = 1; i < 50; ++i) send(i);
    server::RequestRecord odd;
    odd.route = "-";
    odd.status = 404;
    for (const char* method : {"BREW", "X", "get"}) {
        odd.method = method;
        server.metrics.requestEnded(odd);
    }
    // One duration histogram and two of sizes for the method "_OTHER".
    CHECK(lines() <= before + 45);
    CHECK(has(server.metrics.text(*server.service), "http_request_method=\"_OTHER\""));
    CHECK_FALSE(has(server.metrics.text(*server.service), "BREW"));
}

TEST_CASE("metrics: hooks, counts of the pool and health") {
    TestServer server({.workers = 1, .queueLimit = 0});
    server.service->net = &server.http->front().stats();
    server.service->restarts = 7;
    auto client = server.client();
    client.set_keep_alive(true);
    REQUIRE(client.Post("/v1/jobs", "slow", "application/octet-stream")->status == 202);
    // By a client of its own: a refusal that comes before the whole body ends its connection.
    REQUIRE(server.client().Post("/v1/jobs", "slow", "application/octet-stream")->status == 503);
    REQUIRE(server.waitRunning(1));
    const std::string idle = "http_server_open_connections{state=\"idle\"} 1\n";
    for (int i = 0; i < 2000 && !has(server.metrics.text(*server.service), idle); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    for (int i = 0; i < 2; ++i) {
        const std::string text = server.metrics.text(*server.service);
        CHECK(has(text, idle));
        CHECK(has(text, "rivage_admission_rejected_total{reason=\"queue_full\"} 1\n"));
        CHECK(has(text, "rivage_jobs_total{outcome=\"rejected\",reason=\"queue_full\"} 1\n"));
        CHECK(has(text, "rivage_workers_busy 1\n"));
        CHECK(has(text, "rivage_restarts_total 7\n"));
    }
    auto admin = server.adminClient();
    CHECK(admin.Get("/livez")->status == 200);
    CHECK(admin.Get("/startupz")->status == 200);
    server.service->loopBeat = [] { return server::Clock::now() - std::chrono::hours(1); };
    CHECK(admin.Get("/livez")->status == 503);
}

TEST_SUITE_END();
