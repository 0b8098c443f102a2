#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace rivage::test {

/// The values of a NumPy file of version 1.0 with little-endian items of type T; trusts the file.
template <typename T>
std::vector<T> readNpyFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    constexpr std::size_t kPrefix = 10;  // magic, version and the header's length
    if (bytes.size() < kPrefix) throw std::runtime_error("cannot read " + path.string());
    std::uint16_t header = 0;
    std::memcpy(&header, bytes.data() + 8, sizeof header);
    const std::size_t begin = kPrefix + header;
    std::vector<T> values((bytes.size() - begin) / sizeof(T));
    std::memcpy(values.data(), bytes.data() + begin, values.size() * sizeof(T));
    return values;
}

}  // namespace rivage::test
