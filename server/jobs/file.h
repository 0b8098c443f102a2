#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace rivage::server {

/// An open file or folder; closed at the end of its scope.
class File {
public:
    File() = default;
    explicit File(int descriptor) : descriptor_(descriptor) {}
    File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    File& operator=(File&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~File();
    [[nodiscard]] int descriptor() const { return descriptor_; }
    [[nodiscard]] bool isOpen() const { return descriptor_ >= 0; }

private:
    int descriptor_ = -1;
};

/// What a failed system call means for a client: no path in it, only what could not be done.
/// @param doing  "write a result"
/// @param code   value of `errno`
[[nodiscard]] core::Error diskError(const std::string& doing, int code);

/// Makes a folder, and those above it, that only this user may enter; one that exists is fine.
/// @errors storageFull; internal
core::Result<void> makeFolder(const std::string& path);

/// Writes all bytes and waits until the disk has them. @errors storageFull; internal
core::Result<void> writeDurably(const File& file, std::span<const std::byte> bytes);

/// Makes the names in a folder durable: files created, renamed, removed. @errors internal
core::Result<void> syncFolder(const std::string& path);

/// Keeps a second server out of a state folder for as long as the result is open, also in a process
/// that is forked later.
/// @errors busy if another process holds it; storageFull; internal
core::Result<File> lockFolder(const std::string& folder);

}  // namespace rivage::server
