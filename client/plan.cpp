#include "client/plan.h"

#include <filesystem>
#include <set>
#include <system_error>

namespace rivage::client {
namespace {

namespace fs = std::filesystem;

bool isFolder(const std::string& path) {
    std::error_code error;
    return path.ends_with('/') || fs::is_directory(path, error);
}

std::string resultName(const std::string& input, const std::string& extension) {
    const std::string stem = input == kStandardStream ? "stdin" : fs::path(input).stem().string();
    return stem + "." + extension;
}

std::string outputOf(const std::string& input, const std::string& out,
                     const std::string& extension) {
    if (out.empty() && input == kStandardStream) return kStandardStream;
    if (out.empty()) return (fs::path(input).parent_path() / resultName(input, extension)).string();
    if (isFolder(out)) return (fs::path(out) / resultName(input, extension)).string();
    return out;
}

tl::unexpected<Failure> refuse(const std::string& detail) {
    return fail(ExitCode::usage, "Where should the results go", detail);
}

}  // namespace

Outcome<std::vector<PlannedFile>> planFiles(const std::vector<std::string>& inputs,
                                            const std::string& out, const std::string& extension) {
    if (inputs.size() > 1 && !out.empty() && !isFolder(out))
        return refuse("several inputs need a folder after -o: " + out +
                      " is none (a new one ends in /)");
    std::vector<PlannedFile> files;
    std::set<std::string> outputs;
    for (const std::string& input : inputs) {
        PlannedFile file{input, outputOf(input, out, extension)};
        std::error_code error;
        if (!outputs.insert(fs::path(file.output).lexically_normal().string()).second)
            return refuse("two results would be written to " + file.output);
        if (file.output != kStandardStream && fs::is_regular_file(file.output, error) &&
            fs::equivalent(file.input, file.output, error))
            return refuse(file.output + " is the input itself");
        files.push_back(std::move(file));
    }
    return files;
}

}  // namespace rivage::client
