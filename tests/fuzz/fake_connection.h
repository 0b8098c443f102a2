#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace rivage::fuzz {

/// Gives the bytes that a client sends to cpp-httplib as the server uses it, with a route
/// POST /upload that reads headers, options and the body with the server's own functions; all in
/// this thread, without a socket.
///
/// Stops the process if more than the limit is taken as a grid, or if what is refused has no
/// proper problem. The body of a success is the options, the name and the grid.
/// @param piece  how many bytes come at a time, at least 1
/// @return what the server writes
std::string serve(std::string_view request, std::size_t piece = std::string_view::npos);

}  // namespace rivage::fuzz
