#include "server/http/digest_fields.h"

#include <doctest/doctest.h>

#include <span>

#include "server/jobs/digest.h"

using namespace rivage::server;

namespace {

std::string base64Of(const std::string& text) {
    return sha256(std::as_bytes(std::span(text.data(), text.size()))).base64;
}

bool matches(const std::string& field, const std::string& text) {
    const auto digest = parseDigestField(field);
    REQUIRE(digest);
    DigestCheck check(*digest);
    for (const char c : text) check.update(&c, 1);
    return check.matches();
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("parseDigestField: sha-256 is compared, other algorithms are not") {
    const std::string right = "sha-256=:" + base64Of("grid") + ":";
    CHECK(matches(right, "grid"));
    CHECK_FALSE(matches(right, "grid "));
    CHECK_FALSE(matches(right, ""));
    CHECK(matches("sha-512=:AAAA:", "anything"));
    CHECK(matches("md5=:AA==:, " + right + " ,unixsum=::", "grid"));
    CHECK_FALSE(matches("md5=:AA==:," + right, "other"));
    CHECK(matches(right + ";q=1", "grid"));
    CHECK(matches("sha-256=:" + base64Of("") + ":", ""));
}

TEST_CASE("reject: digests that are none") {
    const std::string base64 = base64Of("grid");
    for (const std::string& bad :
         {std::string(), std::string("sha-256"), "sha-256=" + base64, "sha-256=:" + base64,
          "sha-256=:" + base64 + ":x", "sha-256=:" + base64.substr(4) + ":",
          "sha-256=:" + base64 + "AAAA:", std::string("sha-256=::"), "SHA-256=:" + base64 + ":",
          "sha-256=:" + base64 + ":,", "=:" + base64 + ":",
          "sha-256=:" + std::string(44, '=') + ":", "sha-256=:" + std::string(44, '!') + ":",
          "sha-256=:" + std::string(44, 'A') + ":", std::string("md5=:A:")}) {
        CAPTURE(bad);
        const auto digest = parseDigestField(bad);
        REQUIRE_FALSE(digest);
        CHECK(digest.error().code == rivage::core::ErrorCode::malformedRequest);
    }
}

TEST_SUITE_END();
