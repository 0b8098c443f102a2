#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/http/digest_fields.h"
#include "server/http/exchange.h"

namespace rivage::server {

/// What came with a request: the grid, and the options part of a form.
struct Upload {
    std::vector<std::byte> grid;
    std::string options;  ///< JSON, or empty
    std::string name;     ///< file name of the grid, without extension; safe in a header; or empty
};

/// What the headers say about a body.
struct UploadHead {
    std::string encoding;                 ///< a known one, or empty
    std::optional<std::string> boundary;  ///< of a form
    std::optional<std::uint64_t> length;  ///< of the body as it is sent
    std::string name;                     ///< of the file, as in `Upload`; a form says it itself
    std::optional<Sha256> contentDigest;  ///< of the body as it is sent
    std::optional<Sha256> reprDigest;     ///< of the body as it is meant, decoded
};

/// Reads what can be said before the body: its length, form, encoding and digests.
/// @errors 415 for an unknown encoding; 413 by Content-Length; 400 for a malformed digest or form
Answer<UploadHead> readUploadHead(const httplib::Request& request, const Service& service);

/// As `readUploadHead`, and takes a share of the upload budget, which is kept with the response.
/// @errors as above; 503 if all uploads in flight leave no room
Answer<void> admitUpload(const httplib::Request& request, httplib::Response& response,
                         Service& service);

/// Reads the body: the raw grid, or a form with the parts `grid` and `options`, either of them
/// compressed as a whole. Never holds more than the limit, however the body is encoded, and never
/// more than its share of the upload budget. An upload after `admitUpload`.
/// @errors 413; 503 if the upload budget is used up; 400 if the body is broken, empty, or a form
///         with other parts, or not what its digests say; 408 if it is too slow
Answer<Upload> readUpload(Exchange& exchange);

}  // namespace rivage::server
