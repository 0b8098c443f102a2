#include "client/plan.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "client/compare/glb_document.h"

namespace rivage::client {
namespace {

namespace fs = std::filesystem;

bool isFolder(const std::string& path) {
    std::error_code error;
    return path.ends_with('/') || fs::is_directory(path, error);
}

tl::unexpected<Failure> refuse(const std::string& detail) {
    return fail(ExitCode::usage, "Where should the results go", detail);
}

/// The path of a grid, also of a packed one ("brain.nii.gz"), with another extension.
fs::path renamed(fs::path path, const std::string& extension) {
    if (path.extension() == ".gz") path.replace_extension();
    return path.replace_extension(extension);
}

std::string outputOf(const InputFile& input, const std::string& out, bool intoFolder,
                     const std::string& extension) {
    if (out.empty() && input.path == kStandardStream) return kStandardStream;
    if (out.empty()) return renamed(input.path, extension).string();
    if (!intoFolder) return out;
    return (fs::path(out) / renamed(input.below, extension)).string();
}

/// Whether a GLB of ours tells these options.
bool tells(const std::string& path, const proto::Json& options) {
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto document = GlbDocument::open(bytes, {});
    if (!document) return false;
    const proto::Json& extras = memberOf(memberOf(document->json(), "asset"), "extras");
    const proto::Json& told = memberOf(memberOf(extras, "rivage"), "options");
    // In the order of their names, whatever the order there.
    return nlohmann::json(told) == nlohmann::json(options);
}

std::string normal(const std::string& path) { return fs::path(path).lexically_normal().string(); }

}  // namespace

Outcome<std::vector<PlannedFile>> planFiles(const Inputs& inputs, const std::string& out,
                                            const std::string& extension) {
    const bool several = inputs.many || inputs.files.size() > 1;
    std::error_code error;
    const bool isNoFolder = out == kStandardStream || (fs::exists(out, error) && !isFolder(out));
    if (several && !out.empty() && !isFolder(out) && (!inputs.many || isNoFolder))
        return refuse("several inputs need a folder after -o: " + out +
                      " is none (a new one ends in /)");
    const bool intoFolder = inputs.many || (!out.empty() && isFolder(out));

    std::set<std::string> sources;
    for (const InputFile& input : inputs.files) sources.insert(normal(input.path));
    std::map<std::string, std::string> inputOf;
    std::vector<PlannedFile> files;
    for (const InputFile& input : inputs.files) {
        PlannedFile file{input.path, outputOf(input, out, intoFolder, extension)};
        const auto [other, isNew] = inputOf.emplace(normal(file.output), file.input);
        if (!isNew)
            return refuse("the results of " + other->second + " and " + file.input +
                          " would both be written to " + file.output);
        const bool same =
            file.output != kStandardStream && (sources.count(normal(file.output)) > 0 ||
                                               (fs::is_regular_file(file.output, error) &&
                                                fs::equivalent(file.input, file.output, error)));
        if (same) return refuse(file.output + " is an input itself");
        files.push_back(std::move(file));
    }
    return files;
}

bool isUpToDate(const PlannedFile& file, const proto::Json& options) {
    std::error_code error;
    const auto result = fs::last_write_time(file.output, error);
    if (error || !fs::is_regular_file(file.output, error)) return false;
    const auto grid = fs::last_write_time(file.input, error);
    return !error && grid < result &&
           (!file.output.ends_with(".glb") || tells(file.output, options));
}

}  // namespace rivage::client
