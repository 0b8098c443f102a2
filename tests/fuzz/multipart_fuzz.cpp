#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "tests/fuzz/check.h"
#include "tests/fuzz/fake_connection.h"

using namespace rivage;

namespace {

constexpr std::string_view kAccepted = "HTTP/1.1 200 ";

std::string_view bodyOf(std::string_view answer) {
    return answer.substr(std::min(answer.find("\r\n\r\n"), answer.size()));
}

}  // namespace

/// The first byte chooses the encoding, whether the body is a form with the boundary "b", and the
/// pieces in which it comes; the rest is the body, sent with its length. How it comes must change
/// nothing, only the reason of a refusal: a defect may come after a limit that was passed.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    constexpr std::array<const char*, 4> kEncodings = {"", "Content-Encoding: gzip\r\n",
                                                       "Content-Encoding: zstd\r\n",
                                                       "Content-Encoding: deflate\r\n"};
    std::string request = "POST /upload HTTP/1.1\r\nHost: h\r\n";
    request += kEncodings[data[0] & 3];
    request += (data[0] & 4) != 0 ? "Content-Type: application/octet-stream\r\n"
                                  : "Content-Type: multipart/form-data; boundary=b\r\n";
    request += "Content-Length: " + std::to_string(size - 1) + "\r\n\r\n";
    request.append(reinterpret_cast<const char*>(data + 1), size - 1);
    const std::string whole = fuzz::serve(request);
    const std::string pieces = fuzz::serve(request, 1 + (data[0] >> 3));
    const bool accepted = whole.starts_with(kAccepted);
    fuzz::require(whole.starts_with("HTTP/1.1 ") && pieces.starts_with("HTTP/1.1 "));
    fuzz::require(accepted == pieces.starts_with(kAccepted));
    fuzz::require(!accepted || bodyOf(whole) == bodyOf(pieces));
    return 0;
}
