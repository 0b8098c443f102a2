#include "server/http/trace.h"

#include <doctest/doctest.h>

using namespace rivage::server;

namespace {

const std::string kId = "0af7651916cd43dd8448eb211c80319c";
const std::string kSpan = "b7ad6b7169203331";
const std::string kGood = "00-" + kId + "-" + kSpan + "-01";

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("parseTraceparent: version 00, and what later versions share with it") {
    const auto trace = parseTraceparent(kGood);
    REQUIRE(trace);
    CHECK(trace->traceId == kId);
    CHECK(trace->parentId == kSpan);
    CHECK(trace->flags == "01");
    CHECK(parseTraceparent("00-" + kId + "-" + kSpan + "-ff")->flags == "01");
    CHECK(parseTraceparent("00-" + kId + "-" + kSpan + "-fe")->flags == "00");
    CHECK(parseTraceparent("cc-" + kId + "-" + kSpan + "-01"));
    CHECK(parseTraceparent("cc-" + kId + "-" + kSpan + "-01-what-the-future-brings"));
}

TEST_CASE("reject: every prefix of a traceparent, and what breaks its form") {
    for (std::size_t i = 0; i < kGood.size(); ++i)
        CHECK_FALSE(parseTraceparent(kGood.substr(0, i)));
    for (const std::string& bad :
         {kGood + "x", kGood + "-01", "ff-" + kId + "-" + kSpan + "-01",
          "cc-" + kId + "-" + kSpan + "-01x", "00-" + std::string(32, '0') + "-" + kSpan + "-01",
          "00-" + kId + "-" + std::string(16, '0') + "-01", "0x-" + kId + "-" + kSpan + "-01",
          "00-" + kId + "-" + kSpan + "-0g", "00-" + std::string(32, 'A') + "-" + kSpan + "-01",
          "00_" + kId + "-" + kSpan + "-01", "00-" + kId + "_" + kSpan + "-01",
          "00-" + kId + "-" + kSpan + "_01"}) {
        CAPTURE(bad);
        CHECK_FALSE(parseTraceparent(bad));
    }
}

TEST_CASE("traceOf: goes on with the caller's trace, or begins one") {
    httplib::Request request;
    httplib::Response response;
    request.set_header("traceparent", kGood);
    const Trace trace = traceOf(request, response);
    CHECK(trace.traceId == kId);
    CHECK(trace.parentId == kSpan);
    CHECK(trace.spanId != kSpan);
    CHECK(parseTraceparent(trace.traceparent()));
    CHECK(traceOf(request, response).spanId == trace.spanId);
    CHECK(traceOf(response).spanId == trace.spanId);

    httplib::Response other;
    request.headers.emplace("traceparent", kGood);
    const Trace fresh = traceOf(request, other);  // two are none
    CHECK(fresh.traceId != kId);
    CHECK(fresh.parentId.empty());
    CHECK(parseTraceparent(fresh.traceparent()));
}

TEST_SUITE_END();
