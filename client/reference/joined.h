#pragma once

#include <string>
#include <vector>

namespace rivage::client {

/// The texts one after the other, with `between` between them.
[[nodiscard]] inline std::string joined(const std::vector<std::string>& texts,
                                        const char* between) {
    std::string all;
    for (std::size_t i = 0; i < texts.size(); ++i) all += (i == 0 ? "" : between) + texts[i];
    return all;
}

}  // namespace rivage::client
