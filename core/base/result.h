#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace rivage::core {

/// What went wrong, in terms of what the caller can do about it. Each code is one problem type of
/// the HTTP interface (`proto/problem.h` holds the one switch from code to status and URI).
enum class ErrorCode : std::uint8_t {
    malformedInput,     ///< the bytes break their own format
    unsupportedFormat,  ///< the format, or a version or feature of it, is not one we read
    tooLarge,           ///< more bytes, voxels or surfels than the limit
    emptyGrid,          ///< well-formed, but no voxel is left to regularize
    tooManyLabels,      ///< more labels or materials than the limit
    memoryBudget,       ///< the predicted memory is above the budget
    unknownOption,      ///< an option of this name does not exist
    invalidOption,      ///< an option's value is malformed or out of range
    malformedRequest,   ///< the request around the grid is malformed
    notFound,
    methodNotAllowed,
    expired,   ///< it existed, its time to live is over
    busy,      ///< full now, try again later
    draining,  ///< stopping, try elsewhere
    cancelled,
    timedOut,        ///< the deadline passed
    notConverged,    ///< the solver stopped above its tolerance
    outputTooLarge,  ///< the artifact does not fit its format
    unauthorized,    ///< no key, or one that is not known
    forbidden,       ///< the key is known, but may not do this
    quotaExceeded,   ///< this key has asked for too much; later it may again
    digestMismatch,  ///< the bytes are not those that their sender digested
    keyReused,       ///< an idempotency key came back with another request
    keyInProgress,   ///< the request with this idempotency key is still being received
    poison,          ///< this input was running at two crashes
    storageFull,     ///< the disk of jobs and results has no room
    internal,
};

/// A failure caused by data or time. `message` is written for the person who sent the input;
/// `field` is a JSON pointer to what caused it ("/options/alpha", "/grid/dims").
struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string message;
    std::string field = {};
    std::optional<std::uint64_t> limit = {};   ///< the limit in force, in the unit of `message`
    std::optional<std::uint64_t> actual = {};  ///< what the input has or asks for
    std::string setting = {};                  ///< the server flag that raises the limit
};

template <typename T>
using Result = tl::expected<T, Error>;

/// Shorthand for `return fail(...)` in a function that returns any `Result`.
[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
    return tl::unexpected<Error>(std::move(error));
}
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message,
                                                std::string field = {}) {
    return fail(Error{code, std::move(message), std::move(field)});
}

}  // namespace rivage::core
