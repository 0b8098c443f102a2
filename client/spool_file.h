#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "client/failure.h"

namespace rivage::client {

/// Bytes kept until they are known to be whole: in a temporary file without a name, gone with the
/// object or the process; where no such file can be made, in memory.
class SpoolFile {
public:
    /// @errors notWritten if neither can be had
    static Outcome<SpoolFile> open();
    SpoolFile(SpoolFile&& other) noexcept
        : file_(std::exchange(other.file_, -1)), size_(other.size_), error_(other.error_) {}
    SpoolFile& operator=(SpoolFile&&) = delete;
    ~SpoolFile();

    /// Appends; false if that failed.
    bool write(std::string_view bytes);
    /// Drops everything written so far.
    bool restart();
    [[nodiscard]] std::uint64_t size() const { return size_; }
    /// @errors notWritten if a write has failed
    [[nodiscard]] Outcome<void> writable() const;
    /// Hands everything to `take`, in pieces; false as soon as it, or the disk, says no.
    bool copyTo(const std::function<bool(std::string_view)>& take) const;

private:
    SpoolFile() = default;
    int file_ = -1;
    std::uint64_t size_ = 0;
    int error_ = 0;  ///< errno of the first write that failed
};

}  // namespace rivage::client
