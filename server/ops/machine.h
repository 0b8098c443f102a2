#pragma once

#include <cstddef>
#include <cstdint>

namespace rivage::server {

/// Processors that this process may use: the affinity mask, cut by the CPU quota of its cgroup
/// (version 1 or 2); at least 1.
[[nodiscard]] std::size_t usableProcessors();

/// Bytes of memory that this process may use: physical memory, cut by the limit of its cgroup.
[[nodiscard]] std::uint64_t usableMemory();

/// Keeps the memory of this process flat: one malloc arena, so that what lives long lies together;
/// large blocks go back to the system at once.
void tuneMemory();

}  // namespace rivage::server
