#include "server/ops/log.h"

#include <doctest/doctest.h>

using namespace rivage;
using namespace rivage::server;

namespace {

RequestRecord someRecord() {
    RequestRecord record;
    record.id = "id-1";
    record.method = "GET";
    record.route = "/v1/jobs/{id}";
    record.status = 404;
    record.problem = "not-found";
    record.outcome = "client_error";
    record.milliseconds = 1.23456;
    return record;
}

}  // namespace

TEST_SUITE_BEGIN("server/ops");

TEST_CASE("log: the line of a request has these names and types, in JSON") {
    const auto line = proto::readJson(
        logLine(LogFormat::json, "info", "request", requestFacts(someRecord())), "");
    REQUIRE(line);
    for (const char* name : {"time", "level", "event", "id", "trace_id", "span", "parent_span",
                             "caller", "client", "method", "route", "outcome", "problem"}) {
        CAPTURE(name);
        REQUIRE(line->contains(name));
        CHECK((*line)[name].is_string());
    }
    for (const char* name : {"status", "ms", "queue_ms", "compute_ms", "bytes_in", "bytes_out"}) {
        CAPTURE(name);
        REQUIRE(line->contains(name));
        CHECK((*line)[name].is_number());
    }
    CHECK((*line)["ms"] == 1.235);
    CHECK((*line)["event"] == "request");
    CHECK_FALSE(line->contains("job"));
    CHECK(line->size() == 19);
}

TEST_CASE("log: nothing that a client sends can forge a line or a fact") {
    for (const std::string& evil :
         {std::string("a\nb"), std::string("a\r\nlevel=info"), std::string("x event=job"),
          std::string("\x1b[31m"), std::string("\"} {\""), std::string("\xe2\x80\xa8x"),
          std::string("a\0b", 3), std::string("\xff\xfe")}) {
        const proto::Json facts{{"id", evil}, {"status", 200}};
        const std::string text = logLine(LogFormat::text, "info", "request", facts);
        for (const char c : text) CHECK((c >= 0x20 && c < 0x7f));
        const std::string json = logLine(LogFormat::json, "info", "request", facts);
        CHECK(json.find('\n') == std::string::npos);
        const auto line = proto::readJson(json, "");
        REQUIRE(line);
        CHECK(line->size() == 5);
        CHECK((*line)["event"] == "request");
    }
    CHECK(logLine(LogFormat::text, "info", "e", {{"id", "x event=job"}, {"a", ""}}) ==
          "e id=\"x event=job\" a=-");
    CHECK(logLine(LogFormat::text, "info", "e", {{"id", "a\" b=\"c"}}) == "e id=\"a\\\" b=\\\"c\"");
}

TEST_SUITE_END();
