#pragma once

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/pipeline.h"
#include "core/samples/samples.h"

namespace rivage::test {

/// A grid file and how its materials become labels.
struct Input {
    std::string name;
    std::vector<std::byte> bytes;
    core::InputOptions options = {};
};

inline std::vector<std::byte> readFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::vector<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

/// The grids of these files, or all sample scenes if there are none.
inline std::vector<Input> inputs(int count, char** files) {
    std::vector<Input> all;
    for (int i = 0; i < count; ++i) {
        const std::filesystem::path path = files[i];
        all.push_back({path.stem().string(), readFile(path)});
    }
    if (count > 0) return all;
    for (const core::SampleInfo& info : core::sampleInfos()) {
        const std::string name(info.name);
        all.push_back({name, *core::sampleScene(name), {.labels = info.labels}});
    }
    return all;
}

}  // namespace rivage::test
