#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "client/load/exchange.h"
#include "proto/json.h"

namespace rivage::client::load {

/// The class of a fault between two machines: "connect-refused", "reset-mid-body", ...
[[nodiscard]] const char* nameOf(Fault fault);

/// Reads an object that a server has sent, which may be hostile: depth and size are bounded.
/// @return null if the text is no JSON object or is beyond the bounds
[[nodiscard]] proto::Json readAnswer(std::string_view text, std::size_t maxBytes = 1 << 20);

/// The class of a problem document or of the `error` of a job: its type without the path, such as
/// "queue-full"; empty if the text is no problem.
[[nodiscard]] std::string problemSlug(std::string_view body);

/// The same of a document that has been read.
[[nodiscard]] std::string slugOf(const proto::Json& problem);

/// The class of an exchange that is not what its sender hoped for: "timeout", "413 too-large",
/// "429 quota-exceeded", "503-shed busy", "500", "unexpected 302". Empty if it is good (2xx).
[[nodiscard]] std::string errorClass(const Exchange& exchange);

/// 429 and 503: the server wants no more for now.
[[nodiscard]] bool isRefusal(const Exchange& exchange);

}  // namespace rivage::client::load
