#include <array>
#include <cstdint>

#include "tests/fuzz/check.h"
#include "tests/fuzz/fake_connection.h"

using namespace rivage;

/// The first byte chooses the encoding and whether the body is a form with the boundary "b"; the
/// rest is the body, sent with its length.
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
    fuzz::require(fuzz::serve(request).starts_with("HTTP/1.1 "));
    return 0;
}
