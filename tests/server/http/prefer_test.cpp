#include "server/http/prefer.h"

#include <doctest/doctest.h>

using namespace rivage::server;
using namespace std::chrono_literals;

TEST_SUITE_BEGIN("server/http");

TEST_CASE("parsePrefer: what RFC 7240 allows, and nothing from what it does not") {
    CHECK(parsePrefer("respond-async").respondAsync);
    CHECK(parsePrefer("wait=5").wait == 5s);
    CHECK(parsePrefer("wait = \"5\"").wait == 5s);
    CHECK(parsePrefer("wait=99999999").wait == 86400s);
    const Prefer both = parsePrefer("handling=lenient, respond-async; x=y ,wait=0");
    CHECK(both.respondAsync);
    CHECK(both.wait == 0s);
    CHECK(both.applied() == "respond-async, wait=0");
    CHECK(parsePrefer("wait=1, wait=2").wait == 1s);
    for (const char* text : {"", "wait", "wait=", "wait=-1", "wait=1x", "wait=1e9",
                             "wait=99999999999999999999", "respond-asynchronously", ",;=,,"}) {
        CAPTURE(text);
        CHECK_FALSE(parsePrefer(text).wait);
        CHECK(parsePrefer(text).applied().empty());
    }
}

TEST_SUITE_END();
