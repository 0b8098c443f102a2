#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "client/failure.h"
#include "client/interrupt.h"

namespace rivage::client {

/// Wakes up when something changes in folders (inotify). What changed it does not tell: whoever
/// woke up looks, and so misses nothing that came too fast or under another name.
class FolderWatch {
public:
    /// @errors failed if the system has no place for another watch
    static Outcome<FolderWatch> open();
    FolderWatch(FolderWatch&& other) noexcept;
    FolderWatch& operator=(FolderWatch&&) = delete;
    ~FolderWatch();

    /// Watches a folder, and with `deep` the folders below it but hidden ones; those that are
    /// watched already stay so. One that is not there is passed over.
    /// @errors failed if the system has no place for another watch
    Outcome<void> add(const std::string& folder, bool deep);

    /// Waits until something has changed and then nothing more for a moment, as editors write in
    /// several steps; or until `patience` is over, or a stop is asked for.
    void wait(Interrupt& interrupt, std::chrono::milliseconds patience);

private:
    FolderWatch() = default;
    [[nodiscard]] bool drain() const;
    int file_ = -1;
};

}  // namespace rivage::client
