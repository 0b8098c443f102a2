#pragma once

#include <string>
#include <vector>

#include "client/failure.h"

namespace rivage::client {

inline constexpr const char* kStandardStream = "-";

/// A grid to convert.
struct InputFile {
    std::string path;   ///< "-" is stdin
    std::string below;  ///< its path below the folder or pattern that named it; else its name
};

/// What was met in a search, and could not be looked at.
struct Unread {
    std::string path;
    std::string why;
};

/// The inputs of a run, and what they were named by.
struct Inputs {
    std::vector<InputFile> files;
    std::vector<std::string> folders;  ///< that are searched, at any depth; empty: only files
    std::vector<Unread> unread;        ///< folders, and files that a folder or pattern means
    bool many = false;                 ///< a folder or a pattern was named: results need a folder
};

/// Finds what is named: files and "-" as they are; of folders all grids (`extensions`) at any depth
/// but hidden ones; of patterns that the shell left alone (`*`, `?`, `[a-z]`, and `**` for any
/// number of folders) all files that match. Each file once, in the order of the names.
/// @param extensions  of grids, with dot, lower case
/// @errors usage if a folder holds no grid, cannot be read, or nothing matches, unless `mayBeEmpty`
Outcome<Inputs> findInputs(const std::vector<std::string>& names,
                           const std::vector<std::string>& extensions, bool mayBeEmpty);

/// Whether a path matches a pattern, both with '/' between folders. `*`, `?` and `[...]` stay within
/// one name and do not match the dot a hidden name begins with.
[[nodiscard]] bool matchesPattern(const std::string& path, const std::string& pattern);

}  // namespace rivage::client
