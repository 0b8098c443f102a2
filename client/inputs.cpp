#include "client/inputs.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

namespace rivage::client {
namespace {

namespace fs = std::filesystem;

bool isPattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

std::vector<std::string> split(const std::string& path) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        if (end > begin) parts.push_back(path.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

using Parts = std::vector<std::string>::const_iterator;

/// @cost exponential in the number of "**", of which a pattern has one or two
bool matches(Parts part, Parts lastPart, Parts rule, Parts lastRule) {
    if (rule == lastRule) return part == lastPart;
    if (*rule == "**") {
        for (Parts from = part;; ++from) {
            if (matches(from, lastPart, rule + 1, lastRule)) return true;
            if (from == lastPart || from->starts_with('.')) return false;
        }
    }
    return part != lastPart && fnmatch(rule->c_str(), part->c_str(), FNM_PERIOD) == 0 &&
           matches(part + 1, lastPart, rule + 1, lastRule);
}

std::string lowerCase(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
    return text;
}

/// All files below a folder but hidden ones, sorted. What cannot be read is passed over.
std::vector<std::string> filesBelow(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code error;
    const auto options = fs::directory_options::skip_permission_denied;
    fs::recursive_directory_iterator entry(folder, options, error);
    for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
        std::error_code ignored;
        if (entry->path().filename().native().starts_with('.'))
            entry.disable_recursion_pending();
        else if (entry->is_regular_file(ignored))
            files.push_back(entry->path().lexically_relative(folder).string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// Finds what one name means and adds it.
class Finder {
public:
    explicit Finder(const std::vector<std::string>& extensions) : extensions_(extensions) {}

    /// @return  how many files the name means
    std::size_t add(const std::string& name) {
        std::error_code ignored;
        if (name != kStandardStream && fs::is_directory(name, ignored))
            return addBelow(name, [this](const std::string& file) { return isGrid(file); });
        if (isPattern(name) && !fs::exists(name, ignored)) return addPattern(name);
        addFile({name, name == kStandardStream ? "stdin" : fs::path(name).filename().string()});
        return 1;
    }

    Inputs take() { return std::move(found_); }

private:
    [[nodiscard]] bool isGrid(const std::string& file) const {
        const std::string extension = lowerCase(fs::path(file).extension().string());
        return std::find(extensions_.begin(), extensions_.end(), extension) != extensions_.end();
    }

    std::size_t addPattern(const std::string& pattern) {
        // The folders before the first wildcard are where the search begins.
        const std::size_t slash = pattern.rfind('/', pattern.find_first_of("*?["));
        const std::string folder =
            slash == std::string::npos ? "." : pattern.substr(0, std::max<std::size_t>(slash, 1));
        const std::string rule = slash == std::string::npos ? pattern : pattern.substr(slash + 1);
        return addBelow(folder,
                        [&](const std::string& file) { return matchesPattern(file, rule); });
    }

    template <typename Wanted>
    std::size_t addBelow(const std::string& folder, Wanted wanted) {
        found_.many = true;
        found_.folders.push_back(folder);
        std::size_t count = 0;
        for (const std::string& file : filesBelow(folder)) {
            if (!wanted(file)) continue;
            addFile({folder == "." ? file : (fs::path(folder) / file).string(), file});
            ++count;
        }
        return count;
    }

    void addFile(InputFile file) {
        if (known_.insert(fs::path(file.path).lexically_normal().string()).second)
            found_.files.push_back(std::move(file));
    }

    const std::vector<std::string>& extensions_;
    Inputs found_;
    std::set<std::string> known_;
};

}  // namespace

bool matchesPattern(const std::string& path, const std::string& pattern) {
    const std::vector<std::string> parts = split(path);
    const std::vector<std::string> rules = split(pattern);
    return matches(parts.begin(), parts.end(), rules.begin(), rules.end());
}

Outcome<Inputs> findInputs(const std::vector<std::string>& names,
                           const std::vector<std::string>& extensions, bool mayBeEmpty) {
    Finder finder(extensions);
    for (const std::string& name : names) {
        if (finder.add(name) > 0 || mayBeEmpty) continue;
        return fail(ExitCode::usage, "There is nothing to convert",
                    name + (isPattern(name) ? " matches no file" : " holds no grid"));
    }
    return finder.take();
}

}  // namespace rivage::client
