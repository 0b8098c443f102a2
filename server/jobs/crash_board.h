#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"

namespace rivage::server {

/// Which inputs run now, and at how many crashes each was running: memory that survives the
/// process, and can be read after it died at any instant. Inputs are named by their sha-256 (hex).
/// Safe to call from several threads.
class CrashBoard {
public:
    static constexpr std::size_t kSlots = 1024;   ///< inputs that run at a time
    static constexpr std::size_t kInputs = 1024;  ///< whose crashes are known; the oldest go first

    /// @param path        a file, made or begun anew if it is none of ours; empty for memory that
    ///                    only processes forked later share
    /// @param quarantine  how long a crash is remembered
    /// @errors            storageFull; internal
    static core::Result<std::unique_ptr<CrashBoard>> open(const std::string& path,
                                                          std::chrono::seconds quarantine);
    ~CrashBoard();
    CrashBoard(const CrashBoard&) = delete;
    CrashBoard& operator=(const CrashBoard&) = delete;

    /// Once, before the first `begin` of a process: counts a crash for every input that the last
    /// process was running when it died, or only for those that were accused.
    /// @return how many inputs got one more
    std::size_t recover();
    /// Crashes of an input that are not forgotten yet.
    [[nodiscard]] int crashes(const std::string& hex) const;

    /// An input begins to run. @param slot  of the worker, below `kSlots`
    void begin(std::size_t slot, const std::string& hex);
    /// The process is about to die because of the input in this slot; callable in a signal handler.
    void accuse(std::size_t slot) noexcept;
    /// The run has ended, whatever its outcome: its input does not crash, so it counts from 0 again.
    void end(std::size_t slot);
    /// The process ends on purpose with jobs under way: none of them counts.
    void clear() noexcept;

private:
    struct Memory;
    CrashBoard(Memory* memory, std::chrono::seconds quarantine)
        : memory_(memory), quarantine_(quarantine) {}
    void count(const unsigned char* digest);

    Memory* const memory_;
    const std::chrono::seconds quarantine_;
    mutable std::mutex mutex_;  ///< of the counts; each slot has one writer
};

}  // namespace rivage::server
