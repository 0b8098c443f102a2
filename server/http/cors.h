#pragma once

#include <httplib.h>

#include <string>
#include <vector>

namespace rivage::server {

/// Lets pages of some origins call (the CORS protocol). Without origins nothing is ever added.
/// Credentials are not allowed: keys travel in headers.

/// Adds what a page needs to read an answer, errors included, once.
/// @param origins  exact ones, as `--cors-origin` has them
void allowOrigin(const std::vector<std::string>& origins, const httplib::Request& request,
                 httplib::Response& response);

/// Whether a browser asks if a page may send a request.
[[nodiscard]] bool isPreflight(const std::vector<std::string>& origins,
                               const httplib::Request& request);

/// The answer to that, after `allowOrigin`: 204, with what may be sent if the origin is allowed.
/// @param methods  of the path
void writePreflight(const std::string& methods, httplib::Response& response);

}  // namespace rivage::server
