#pragma once

#include <cstddef>
#include <string>

#include "proto/problem.h"

namespace rivage::server {

/// So many random bytes, as hexadecimal digits.
[[nodiscard]] std::string randomHex(std::size_t bytes);
/// A request id that nobody has used: 24 digits.
[[nodiscard]] inline std::string randomRequestId() { return randomHex(12); }

/// A whole answer with a problem, for where no request could be read: head and body, after which
/// the connection is closed. 503 says to come back in a second.
[[nodiscard]] std::string cannedAnswer(const proto::Problem& problem, const std::string& requestId);

}  // namespace rivage::server
