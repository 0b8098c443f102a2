#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "proto/json.h"

namespace rivage::proto {

/// A kind of failure as the HTTP interface names it (RFC 9457).
struct ProblemType {
    int status = 500;
    std::string_view slug;  ///< the type URI is "/problems/" + slug
    std::string_view title;
};

/// One failure, as `application/problem+json` says it.
struct Problem {
    ProblemType type;
    std::string detail = {};
    std::string field = {};  ///< JSON pointer
    std::optional<std::uint64_t> limit = {};
    std::optional<std::uint64_t> actual = {};
    std::string setting = {};   ///< the server flag that raises the limit
    std::string instance = {};  ///< URI of the job that failed
};

inline constexpr const char* kProblemMediaType = "application/problem+json";

/// The problem type of an error code: the one switch from codes to HTTP.
[[nodiscard]] ProblemType problemType(core::ErrorCode code);

/// The problem type of a status that the HTTP layer itself answers with.
[[nodiscard]] ProblemType transportProblemType(int status);

[[nodiscard]] Problem makeProblem(const core::Error& error);
[[nodiscard]] Json toJson(const Problem& problem);

/// Every problem type there is, for documents and tests.
[[nodiscard]] std::vector<ProblemType> problemCatalogue();

}  // namespace rivage::proto
