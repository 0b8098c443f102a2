#include "server/jobs/idempotency.h"

#include <doctest/doctest.h>

using namespace rivage;
using namespace rivage::server;
using core::ErrorCode;

namespace {

std::shared_ptr<Job> makeJob() { return std::make_shared<Job>(JobFacts{}, Clock::now()); }

}  // namespace

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("readIdempotencyKey: quoted or bare, 1 to 255 visible characters") {
    CHECK(*readIdempotencyKey("\"a+b\"") == "a+b");
    CHECK(readIdempotencyKey("8e03978e-40d5-43dd-bc93-6894a57f9324")->size() == 36);
    CHECK(readIdempotencyKey('"' + std::string(255, 'x') + '"'));
    for (const std::string& bad :
         {std::string(), std::string("\"\""), std::string("a b"), std::string("a\tb"),
          std::string("\"a\"b\""), std::string("a,b"), std::string("a;b=1"),
          std::string("\"a\\b\""), std::string("\xc3\xa9"), std::string(256, 'x'),
          std::string("\"")}) {
        CAPTURE(bad);
        const auto read = readIdempotencyKey(bad);
        REQUIRE_FALSE(read);
        CHECK(read.error().code == ErrorCode::malformedRequest);
        CHECK(read.error().field == "/headers/idempotency-key");
    }
}

TEST_CASE("IdempotencyKeys: the first request claims, the next ones find its job") {
    IdempotencyKeys keys;
    const auto job = makeJob();
    {
        auto first = keys.claim("ann", "k");
        REQUIRE(first);
        CHECK_FALSE(first->job);
        CHECK(keys.claim("ann", "k").error().code == ErrorCode::keyInProgress);
        CHECK(keys.claim("bob", "k"));
        first->claim.settle(job);
    }
    CHECK(keys.claim("ann", "k")->job == job);
    CHECK(keys.claim("ann", "k")->job == job);
}

TEST_CASE("IdempotencyKeys: a claim without a job is given back") {
    IdempotencyKeys keys;
    { const auto first = keys.claim("", "k"); }
    const auto second = keys.claim("", "k");
    REQUIRE(second);
    CHECK_FALSE(second->job);
}

TEST_CASE("IdempotencyKeys: a key is free again when its job is gone") {
    IdempotencyKeys keys;
    keys.claim("", "k")->claim.settle(makeJob());
    keys.sweep();
    CHECK_FALSE(keys.claim("", "k")->job);
}

TEST_SUITE_END();
