#pragma once

#include <httplib.h>

#include <optional>
#include <string>
#include <string_view>

namespace rivage::server {

/// Where a request stands in a distributed trace (W3C Trace Context): lower-case hexadecimal.
struct Trace {
    std::string traceId;       ///< 32 digits, not all 0
    std::string parentId;      ///< 16 digits: the caller's span; empty if the trace begins here
    std::string spanId;        ///< 16 digits: ours
    std::string flags = "00";  ///< 2 digits

    /// The traceparent of what we start.
    [[nodiscard]] std::string traceparent() const;
};

/// Reads a traceparent: version 00 exactly, later ones by what they share with it.
/// @return its trace and its span as `parentId`; nothing if it is malformed or an id is all 0
[[nodiscard]] std::optional<Trace> parseTraceparent(std::string_view text);

/// The trace of a request: the caller's, if it sent one valid traceparent, else a new one; with a
/// span of our own. Kept with the response.
const Trace& traceOf(const httplib::Request& request, httplib::Response& response);
/// The trace that `traceOf` has kept, or an empty one.
[[nodiscard]] const Trace& traceOf(const httplib::Response& response);

}  // namespace rivage::server
