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

/// A file that a search has met.
struct Met {
    std::string below;  ///< its path below the folder of the search
    std::string why;    ///< it cannot be looked at; empty: it can
};

/// Walks through a folder and those below it, but hidden ones and links to folders.
class Walk {
public:
    Walk(std::string folder, std::vector<Unread>& unread)
        : folder_(std::move(folder)), unread_(unread) {
        for (open_.push_back({}); !open_.empty();) {
            const std::string next = std::move(open_.back());
            open_.pop_back();
            look(next);
        }
        std::sort(met_.begin(), met_.end(),
                  [](const Met& a, const Met& b) { return a.below < b.below; });
    }
    [[nodiscard]] const std::vector<Met>& met() const { return met_; }

private:
    void look(const std::string& below) {
        const fs::path folder = below.empty() ? fs::path(folder_) : fs::path(folder_) / below;
        std::error_code error;
        fs::directory_iterator entry(folder, error);
        for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
            const std::string name = entry->path().filename().string();
            if (name.starts_with('.')) continue;
            look(*entry, (fs::path(below) / name).string());
        }
        if (error && error != std::errc::no_such_file_or_directory)
            unread_.push_back({folder.string(), error.message()});
    }

    void look(const fs::directory_entry& entry, std::string below) {
        std::error_code error;
        const bool link = entry.is_symlink(error);
        const fs::file_status status = entry.status(error);
        if (status.type() == fs::file_type::directory) {
            if (!link) open_.push_back(std::move(below));
        } else if (status.type() == fs::file_type::regular) {
            met_.push_back({std::move(below), {}});
        } else if (status.type() == fs::file_type::none && link) {
            met_.push_back({std::move(below), error.message()});
        } else if (status.type() == fs::file_type::none) {  // whatever its name: maybe a folder
            unread_.push_back({entry.path().string(), error.message()});
        } else if (link && status.type() == fs::file_type::not_found) {
            met_.push_back({std::move(below), "it is a link to nothing"});
        }
    }

    std::string folder_;
    std::vector<Unread>& unread_;
    std::vector<std::string> open_;
    std::vector<Met> met_;
};

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

    [[nodiscard]] const std::vector<Unread>& unread() const { return found_.unread; }
    Inputs take() { return std::move(found_); }

private:
    [[nodiscard]] bool isGrid(const std::string& file) const {
        const std::string name = lowerCase(file);
        return std::any_of(extensions_.begin(), extensions_.end(),
                           [&](const std::string& end) { return name.ends_with(end); });
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
        const Walk walk(folder, found_.unread);
        for (const Met& file : walk.met()) {
            if (!wanted(file.below)) continue;
            const std::string path =
                folder == "." ? file.below : (fs::path(folder) / file.below).string();
            if (!file.why.empty()) {
                found_.unread.push_back({path, file.why});
                continue;
            }
            addFile({path, file.below});
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
        const std::size_t before = finder.unread().size();
        if (finder.add(name) > 0 || mayBeEmpty) continue;
        if (finder.unread().size() > before)
            return fail(
                ExitCode::usage, "There is nothing to convert",
                finder.unread().back().path + " cannot be read: " + finder.unread().back().why);
        return fail(ExitCode::usage, "There is nothing to convert",
                    name + (isPattern(name) ? " matches no file" : " holds no grid"));
    }
    return finder.take();
}

}  // namespace rivage::client
