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

/// The files of the viewer, in the order in which they were listed for `rivage_embed`.
[[nodiscard]] std::span<const WebAsset> webAssets();

}  // namespace rivage::server
