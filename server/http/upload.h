#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/http/exchange.h"

namespace rivage::server {

/// What came with a request: the grid, and the options part of a form.
struct Upload {
    std::vector<std::byte> grid;
    std::string options;  ///< JSON, or empty
    std::string name;     ///< file name of the grid, without extension; safe in a header; or empty
};

/// What can be said before the body is read: its length and its encoding.
/// @errors 415 for an unknown encoding; 413 by Content-Length
Answer<void> checkUploadHeaders(const httplib::Request& request, const Service& service);

/// Reads the body: the raw grid, or a form with the parts `grid` and `options`. Never holds more
/// than the limit, however the body is encoded.
/// @errors 413; 400 if the body is broken, empty, or a form with other parts; 408 if it is too slow
Answer<Upload> readUpload(Exchange& exchange);

}  // namespace rivage::server
