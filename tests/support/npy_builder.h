#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/vox_builder.h"

/// Builds .npy files for tests; shares nothing with the project's reader.
namespace rivage::test {

struct NpyFile {
    std::string descr = "|u1";
    bool fortranOrder = false;
    std::string shape = "(2, 3, 4)";
    int version = 1;
    std::vector<std::int64_t> values;  ///< in the order of memory

    [[nodiscard]] std::vector<std::byte> bytes() const {
        std::string header = "{'descr': '" + descr +
                             "', 'fortran_order': " + (fortranOrder ? "True" : "False") +
                             ", 'shape': " + shape + ", }";
        const std::size_t lengthBytes = version == 1 ? 2 : 4;
        while ((8 + lengthBytes + header.size() + 1) % 64 != 0) header += ' ';
        header += '\n';
        std::string text = "\x93NUMPY";
        text += static_cast<char>(version);
        text += '\0';
        for (std::size_t i = 0; i < lengthBytes; ++i)
            text += static_cast<char>(header.size() >> (8 * i) & 0xff);
        text += header;
        const int width = descr.back() - '0';
        for (const std::int64_t value : values)
            for (int i = 0; i < width; ++i) {
                const int byte = descr[0] == '>' ? width - 1 - i : i;
                text += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * byte) & 0xff);
            }
        return VoxBuilder::toBytes(text);
    }
};

}  // namespace rivage::test
