#include "proto/problem.h"

#include <doctest/doctest.h>

#include <set>
#include <string>

using namespace rivage;
using core::ErrorCode;

TEST_SUITE_BEGIN("proto");

TEST_CASE("problemCatalogue: every type has a slug of its own, a title and an error status") {
    std::set<std::string> slugs;
    for (const proto::ProblemType& type : proto::problemCatalogue()) {
        CAPTURE(type.slug);
        CHECK(slugs.insert(std::string(type.slug)).second);
        CHECK_FALSE(type.title.empty());
        CHECK(type.status >= 400);
        CHECK(type.status < 600);
        CHECK(type.slug.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string::npos);
    }
    CHECK(slugs.size() >= 20);
}

TEST_CASE("problemType: the statuses that API users rely on") {
    const std::pair<ErrorCode, int> expected[] = {
        {ErrorCode::malformedInput, 400}, {ErrorCode::unsupportedFormat, 415},
        {ErrorCode::tooLarge, 413},       {ErrorCode::emptyGrid, 422},
        {ErrorCode::tooManyLabels, 422},  {ErrorCode::memoryBudget, 422},
        {ErrorCode::unknownOption, 400},  {ErrorCode::notFound, 404},
        {ErrorCode::expired, 410},        {ErrorCode::busy, 503},
        {ErrorCode::draining, 503},       {ErrorCode::timedOut, 504},
        {ErrorCode::internal, 500},
    };
    for (const auto& [code, status] : expected) CHECK(proto::problemType(code).status == status);
}

TEST_CASE("transportProblemType: a status without a type of its own gets one of its class") {
    CHECK(proto::transportProblemType(431).slug == "headers-too-large");
    CHECK(proto::transportProblemType(404).slug == "not-found");
    CHECK(proto::transportProblemType(418).slug == "malformed-request");
    CHECK(proto::transportProblemType(599).slug == "internal");
}

TEST_CASE("toJson: a problem says what is known, and nothing else") {
    core::Error error{ErrorCode::tooLarge, "too many voxels", "/grid"};
    error.limit = 10;
    error.actual = 11;
    error.setting = "--max-voxels";
    CHECK(proto::writeJson(proto::toJson(proto::makeProblem(error))) ==
          R"({"type":"/problems/too-large","title":"The grid is too large","status":413,)"
          R"("detail":"too many voxels","field":"/grid","limit":10,"actual":11,)"
          R"("setting":"--max-voxels"})");
    const auto bare = proto::toJson(proto::makeProblem({ErrorCode::notFound, ""}));
    CHECK(bare.size() == 3);
}

TEST_SUITE_END();
