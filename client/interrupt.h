#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace rivage::client {

/// Whether the run was asked to stop. Everything that waits waits here or is broken off from here.
class Interrupt {
public:
    /// Asks to stop, and breaks off the request that is under way.
    void request();
    [[nodiscard]] bool requested() const;

    /// Sleeps; false if a stop was asked for, before or meanwhile.
    [[nodiscard]] bool sleep(std::chrono::milliseconds duration) const;

    /// What breaks off the request under way; empty when there is none. Called under a lock, as
    /// often as `request`.
    void setBreak(std::function<void()> breakOff);

private:
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    bool requested_ = false;
    std::function<void()> breakOff_;
};

/// Turns SIGINT, SIGTERM and SIGHUP into `Interrupt::request` for as long as it lives. It blocks
/// them in the thread that makes it, so it has to be made before all other threads.
class SignalWatcher {
public:
    explicit SignalWatcher(Interrupt& interrupt);
    ~SignalWatcher();
    SignalWatcher(const SignalWatcher&) = delete;
    SignalWatcher& operator=(const SignalWatcher&) = delete;

private:
    void watch(Interrupt& interrupt) const;
    int signals_ = -1;  ///< signalfd
    int end_ = -1;      ///< eventfd, written by the destructor
    std::thread thread_;
};

}  // namespace rivage::client
