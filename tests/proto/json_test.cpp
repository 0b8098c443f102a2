#include "proto/json.h"

#include <doctest/doctest.h>

#include <string>

using namespace rivage;
using core::ErrorCode;

namespace {

ErrorCode codeOf(const std::string& text) {
    const auto json = proto::readJson(text, "/options");
    REQUIRE_FALSE(json);
    CHECK(json.error().field == "/options");
    return json.error().code;
}

std::string nested(std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

}  // namespace

TEST_SUITE_BEGIN("proto");

TEST_CASE("readJson: every kind of value comes back as it was written") {
    const std::string text =
        R"({"a":[1,-2,0.5,"x",true,null],"b":{"c":{"d":[]}},"e":18446744073709551615})";
    const auto json = proto::readJson(text, "");
    REQUIRE(json);
    CHECK(proto::writeJson(*json) == text);
}

TEST_CASE("readJson: 32 levels are read, 33 are refused") {
    CHECK(proto::readJson(nested(32), "/options"));
    CHECK(codeOf(nested(33)) == ErrorCode::malformedRequest);
}

TEST_CASE("reject: 200,000 levels, whatever the size limit") {
    const proto::JsonLimits limits{.maxBytes = 1 << 20};
    CHECK_FALSE(proto::readJson(nested(200000), "", limits));
    CHECK_FALSE(proto::readJson(std::string(200000, '['), "", limits));
    std::string objects;
    for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
    CHECK_FALSE(proto::readJson(objects, "", limits));
}

TEST_CASE("reject: what is not JSON") {
    for (const char* text : {"", " ", "{", "[1,]", "{\"a\":1,}", "{'a':1}", "{\"a\":NaN}", "NaN",
                             "Infinity", "-Infinity", "[1e999]", "[-1e999]", "1 2", "{} x",
                             "{\"a\":01}", "\"\xff\"", "\"\\ud800\"", "/* */ 1", "nul"}) {
        CAPTURE(text);
        CHECK(codeOf(text) == ErrorCode::malformedRequest);
    }
}

TEST_CASE("reject: every proper prefix of a text") {
    const std::string text = R"({"alpha":0.5,"labels":{"sea":[1,2],"land":"*"}})";
    for (std::size_t length = 0; length < text.size(); ++length) {
        CAPTURE(length);
        CHECK(codeOf(text.substr(0, length)) == ErrorCode::malformedRequest);
    }
}

TEST_CASE("reject: a member twice, at any depth") {
    CHECK(codeOf(R"({"a":1,"a":1})") == ErrorCode::malformedRequest);
    CHECK(codeOf(R"([{"b":{"a":1,"c":2,"a":3}}])") == ErrorCode::malformedRequest);
}

TEST_CASE("reject: more bytes and more members than the limit") {
    const proto::JsonLimits limits{.maxBytes = 64, .maxMembers = 3};
    CHECK(proto::readJson(R"({"a":1,"b":2,"c":3})", "", limits));
    CHECK_FALSE(proto::readJson(R"({"a":1,"b":2,"c":3,"d":4})", "", limits));
    const auto longer = proto::readJson('"' + std::string(63, 'x') + '"', "", limits);
    REQUIRE_FALSE(longer);
    CHECK(longer.error().limit == 64);
    CHECK(longer.error().actual == 65);
}

TEST_CASE("writeJson: bytes that are not UTF-8 do not throw") {
    CHECK(proto::writeJson({{"a", "x\xff"}}) == "{\"a\":\"x\xEF\xBF\xBD\"}");
}

TEST_CASE("inQuotes: long texts are cut and control characters vanish") {
    CHECK(proto::inQuotes("a\nb") == "\"a?b\"");
    CHECK(proto::inQuotes(std::string(100, 'x')) == '"' + std::string(64, 'x') + "...\"");
}

TEST_SUITE_END();
