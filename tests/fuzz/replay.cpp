#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

/// Runs a fuzz target over every file of the folders it is given, and over every prefix of the
/// small ones, so that targets and corpus never stop working where there is no libFuzzer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

constexpr std::size_t kPrefixBytes = 4096;  // files up to this size are cut at every byte

std::vector<std::uint8_t> readFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

int main(int argc, char** argv) {
    std::size_t inputs = 0;
    for (int i = 1; i < argc; ++i) {
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(argv[i]))
            if (entry.is_regular_file()) files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        for (const auto& path : files) {
            const std::vector<std::uint8_t> bytes = readFile(path);
            const std::size_t first = bytes.size() <= kPrefixBytes ? 0 : bytes.size();
            for (std::size_t length = first; length <= bytes.size(); ++length, ++inputs) {
                // A copy of the exact length, so that a sanitizer sees a read behind the end.
                const std::vector<std::uint8_t> input(bytes.begin(), bytes.begin() + length);
                LLVMFuzzerTestOneInput(input.data(), input.size());
            }
        }
    }
    std::printf("%zu inputs replayed\n", inputs);
    return inputs > 0 ? 0 : 1;
}
