#pragma once

#include <string>

namespace rivage::test {

/// A text in gzip (windowBits 15 + 16) or zlib (15) form.
[[nodiscard]] std::string deflated(const std::string& text, int windowBits);

}  // namespace rivage::test
