#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace rivage::client {

/// Whether the run was asked to stop. Everything that waits waits here or is broken off from here,
/// from any number of threads.
class Interrupt {
public:
    /// Asks to stop, and breaks off the requests that are under way.
    void request();
    [[nodiscard]] bool requested() const;

    /// Sleeps; false if a stop was asked for, before or meanwhile.
    [[nodiscard]] bool sleep(std::chrono::milliseconds duration) const;

    /// Waits until a file can be read or written (`events` of poll); false if a stop was asked for.
    [[nodiscard]] bool await(int file, short events) const;

private:
    friend class BreakOff;
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    bool requested_ = false;
    std::list<std::function<void()>> breaks_;
};

/// What breaks off one request, for as long as it lives. Called under a lock, as often as
/// `Interrupt::request`.
class BreakOff {
public:
    BreakOff(Interrupt& interrupt, std::function<void()> action);
    ~BreakOff();
    BreakOff(const BreakOff&) = delete;
    BreakOff& operator=(const BreakOff&) = delete;

private:
    Interrupt& interrupt_;
    std::list<std::function<void()>>::iterator place_;
};

/// Turns SIGINT, SIGTERM and SIGHUP into `Interrupt::request` for as long as it lives; a second one
/// ends the program at once, whatever it waits for. It blocks
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
