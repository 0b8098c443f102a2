#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace rivage::server {

/// Undoes one Content-Encoding, piece by piece. The memory that a body can make it take is bounded:
/// 64 KiB, and the window: 32 KiB of gzip and deflate, 8 MiB of zstd (RFC 9659).
class BodyDecoder {
public:
    using Sink = std::function<bool(const char* data, std::size_t size)>;
    virtual ~BodyDecoder() = default;

    /// Takes the next bytes of the body and passes on what they stand for, in pieces.
    /// @return false if they break the encoding, or as soon as the sink says no
    virtual bool take(const char* data, std::size_t size, const Sink& sink) = 0;
    /// Whether the body may end here: at the end of the encoded data, with nothing after it.
    [[nodiscard]] virtual bool atEnd() const = 0;
};

/// Whether an encoding of uploads is known: "", identity, gzip, x-gzip, deflate, zstd.
[[nodiscard]] bool knowsEncoding(std::string_view encoding);
/// @param encoding  a known one, in any case @return null for none and identity
[[nodiscard]] std::unique_ptr<BodyDecoder> makeDecoder(std::string_view encoding);

}  // namespace rivage::server
