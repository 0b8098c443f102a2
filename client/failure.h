#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "client/exit_code.h"
#include "proto/json.h"

namespace rivage::client {

/// Why something did not work, in the form of a problem (RFC 9457), with the exit code it means.
struct Failure {
    ExitCode exit = ExitCode::failed;
    proto::Json problem = proto::Json::object();  ///< title, detail, field, limit, setting ...
    std::string job = {};  ///< at the server, where it may go on or have a result; empty: none
};

template <typename T>
using Outcome = tl::expected<T, Failure>;

/// A failure that the client itself found.
[[nodiscard]] tl::unexpected<Failure> fail(ExitCode exit, std::string title,
                                           std::string detail = {});

/// The same, not to be returned at once.
[[nodiscard]] Failure failureWith(ExitCode exit, std::string title, std::string detail = {});

/// The failure behind an HTTP answer.
/// @param body  application/problem+json, or anything: then the status speaks for itself
[[nodiscard]] Failure failureOf(int status, std::string_view body);

/// The failure behind the `error` of a job that failed.
[[nodiscard]] Failure failureOf(const proto::Json& problem);

/// The lines that say a failure to a person: title, detail, and the facts that are known.
[[nodiscard]] std::string describe(const Failure& failure);

/// The JSON object that a server answered with; null if the text is none, or is nested too deeply
/// to be one of ours.
[[nodiscard]] proto::Json readAnswer(std::string_view body);

/// The member `name` of `object` as text; empty if there is none, or if it is not a string.
[[nodiscard]] std::string textOf(const proto::Json& object, const char* name);

/// The member `name` of `object` as a number; `otherwise` if there is none.
[[nodiscard]] double numberOf(const proto::Json& object, const char* name, double otherwise = 0);

}  // namespace rivage::client
