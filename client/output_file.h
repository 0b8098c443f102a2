#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/failure.h"
#include "client/interrupt.h"

namespace rivage::client {

/// A file that appears under its name only when it is whole: it is written beside its place under
/// a temporary name, and `commit` renames it. What is no regular file (a pipe, a device) is written
/// directly. Dropped without `commit`, it leaves nothing behind.
class OutputFile {
public:
    /// @param path       an existing file is replaced by `commit`; a link is followed
    /// @param interrupt  ends the waiting for the reader of a named pipe; null: nothing does
    /// @errors notWritten; cancelled
    static Outcome<OutputFile> open(const std::string& path, const Interrupt* interrupt = nullptr);

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
    /// Whether it is a pipe or a device, which takes nothing back.
    [[nodiscard]] bool direct() const { return temporary_.empty(); }

private:
    OutputFile() = default;
    Outcome<void> openPipe();
    Outcome<void> openBeside(unsigned mode);
    [[nodiscard]] bool mayGoOn(short events) const;
    Outcome<void> finish();

    int file_ = -1;
    int error_ = 0;  ///< errno of the first write that failed
    std::uint64_t size_ = 0;
    const Interrupt* interrupt_ = nullptr;
    std::string path_;
    std::string temporary_;  ///< empty: written directly
};

}  // namespace rivage::client
