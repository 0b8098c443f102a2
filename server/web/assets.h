#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace rivage::server {

/// One file that is built into the server.
struct WebAsset {
    std::string_view path;  ///< as requested, e.g. "/viewer.js"; an index.html is also "/"
    std::string_view mime;
    std::span<const std::byte> bytes;
    std::string_view etag;  ///< strong, quoted: the sha-256 of the bytes
};

/// The Content-Security-Policy that the viewer page needs, and no more: the Draco decoder is
/// WebAssembly in a worker that three.js starts from a blob.
inline constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval' blob:; worker-src blob:; "
    "connect-src 'self' blob:; img-src 'self' blob: data:; style-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

/// The files of the viewer, in the order in which they were listed for `rivage_embed`.
[[nodiscard]] std::span<const WebAsset> webAssets();

}  // namespace rivage::server
