#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "core/base/result.h"
#include "server/net/fd.h"

namespace rivage::server {

/// What a failed system call means for a client: no path in it, only what could not be done.
/// @param doing  "write a result"
/// @param code   value of `errno`
[[nodiscard]] core::Error diskError(const std::string& doing, int code);

/// Makes a folder, and those above it, that only this user may enter; one that exists is fine.
/// @errors storageFull; internal
core::Result<void> makeFolder(const std::string& path);

/// Writes all bytes and waits until the disk has them. @errors storageFull; internal
core::Result<void> writeDurably(const Fd& file, std::span<const std::byte> bytes);

/// Makes the names in a folder durable: files created, renamed, removed. @errors internal
core::Result<void> syncFolder(const std::string& path);

/// Keeps a second server out of a state folder for as long as the result is open, also in a process
/// that is forked later.
/// @errors busy if another process holds it; storageFull; internal
core::Result<Fd> lockFolder(const std::string& folder);

}  // namespace rivage::server
