#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "server/net/limits.h"

namespace rivage::server {

/// What is known of a request's head while it comes in.
struct HeadVerdict {
    bool complete = false;
    int status = 0;           ///< of the refusal, if not 0
    std::uint64_t limit = 0;  ///< that was passed, if any
};

/// Finds the end of a request's head, and refuses at the first byte that no good head has: the
/// limits, and what HTTP parsers read in different ways (bare CR and LF, folded lines, NUL, two
/// lengths, no host or two). Everything else is left to the parser.
class HeadScanner {
public:
    /// @param bytes  all that has come of this request, from its first byte on
    /// @return       the verdict on them; only what is new is looked at
    HeadVerdict scan(std::string_view bytes, const NetLimits& limits);

    /// Bytes of the complete head, with its empty line.
    [[nodiscard]] std::size_t size() const { return at_; }

private:
    [[nodiscard]] int refusal(std::string_view bytes, char previous, char c) const;
    [[nodiscard]] bool endLine(std::string_view line);

    std::size_t at_ = 0;
    std::size_t lineStart_ = 0;
    std::size_t lines_ = 0;
    int framings_ = 0;  ///< lines that say how long the body is
    int hosts_ = 0;     ///< lines that say whom the request is for
    bool old_ = false;  ///< HTTP/1.0, which need not say it
};

}  // namespace rivage::server
