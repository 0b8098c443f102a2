#include "server/http/request_record.h"

#include <doctest/doctest.h>

#include <thread>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

namespace {

constexpr const char* kBytes = "application/octet-stream";
const std::string kTrace = "0af7651916cd43dd8448eb211c80319c";

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("outcomeOf: who failed") {
    struct Case {
        int status;
        const char* problem;
        bool ofJob;
        const char* outcome;
    };
    for (const Case& one :
         std::initializer_list<Case>{{200, "", true, "ok"},
                                     {304, "", false, "ok"},
                                     {400, "malformed-request", false, "client_error"},
                                     {422, "empty-grid", true, "client_error"},
                                     {401, "unauthorized", false, "client_error"},
                                     {408, "request-timeout", false, "timed_out"},
                                     {504, "deadline-exceeded", true, "timed_out"},
                                     {429, "quota-exceeded", false, "rejected"},
                                     {503, "queue-full", false, "rejected"},
                                     {507, "storage-full", false, "rejected"},
                                     {499, "", true, "canceled"},
                                     {422, "not-converged", true, "engine_error"},
                                     {422, "poison", false, "engine_error"},
                                     {500, "internal", true, "engine_error"},
                                     {500, "internal", false, "server_error"}}) {
        CAPTURE(one.status);
        CHECK(server::outcomeOf(one.status, one.problem, one.ofJob) == one.outcome);
    }
}

TEST_CASE("record: trace, caller, route, times and bytes of a request") {
    const TestServer server(
        {.keys = server::keyLine("anna", "0123456789abcdef-anna").value() + "\n"});
    auto client = server.client();
    const httplib::Headers headers{{"X-API-Key", "0123456789abcdef-anna"},
                                   {"traceparent", "00-" + kTrace + "-b7ad6b7169203331-01"}};
    REQUIRE(client.Post("/v1/regularize", headers, "ok grid", kBytes)->status == 200);
    REQUIRE(client.Post("/v1/regularize", headers, "empty", kBytes)->status == 422);
    REQUIRE(client.Get("/v1/jobs/../../x%0aevent=forged")->status >= 400);
    for (int i = 0; i < 2000 && server.records < 3; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const auto seen = server.seen();
    REQUIRE(seen.size() == 3);
    const server::RequestRecord& first = seen[0];
    CHECK(first.traceId == kTrace);
    CHECK(first.parentSpan == "b7ad6b7169203331");
    CHECK(first.spanId.size() == 16);
    CHECK(first.caller == "anna");
    CHECK(first.client == "127.0.0.1");
    CHECK(first.route == "/v1/regularize");
    CHECK(first.outcome == "ok");
    CHECK(first.problem.empty());
    CHECK(first.bytesIn == 7);
    CHECK(first.bytes == std::string("asset of ok grid").size());
    CHECK(first.queueMs > 0);
    CHECK_FALSE(first.job.empty());
    CHECK(seen[1].problem == "empty-grid");
    CHECK(seen[1].outcome == "client_error");
    CHECK(seen[2].route == "-");
    CHECK(seen[2].caller.empty());
}

TEST_SUITE_END();
