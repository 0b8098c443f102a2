#include <cstdint>

#include "tests/fuzz/check.h"
#include "tests/fuzz/fake_connection.h"

using namespace rivage;

/// The input is what a client sends on one connection.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string answer = fuzz::serve({reinterpret_cast<const char*>(data), size});
    fuzz::require(answer.empty() || answer.starts_with("HTTP/1.1 "));
    return 0;
}
