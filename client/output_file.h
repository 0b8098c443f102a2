#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/failure.h"

namespace rivage::client {

/// A file that appears under its name only when it is whole: it is written beside its place under
/// a temporary name, and `commit` renames it. What is no regular file (a pipe, a device) is written
/// directly. Dropped without `commit`, it leaves nothing behind.
class OutputFile {
public:
    /// @param path  an existing file is replaced by `commit`; a link is followed
    /// @errors notWritten
    static Outcome<OutputFile> open(const std::string& path);

    OutputFile(OutputFile&& other) noexcept;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();

    /// Appends; false if that failed, and then `commit` fails too.
    bool write(std::string_view bytes);
    /// @errors notWritten if a write has failed
    [[nodiscard]] Outcome<void> writable() const;
    /// Drops everything written so far; false if this kind of file cannot.
    bool restart();
    /// @errors notWritten
    Outcome<void> commit();
    [[nodiscard]] std::uint64_t size() const { return size_; }

private:
    OutputFile() = default;
    Outcome<void> finish();

    int file_ = -1;
    int error_ = 0;  ///< errno of the first write that failed
    std::uint64_t size_ = 0;
    std::string path_;
    std::string temporary_;  ///< empty: written directly
};

}  // namespace rivage::client
