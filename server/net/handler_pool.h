#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "server/net/limits.h"

namespace rivage::server {

struct Connection;

/// Threads that answer requests. One is started whenever more requests wait than threads are idle,
/// so that no number of long requests holds up a short one before the cap is reached.
class HandlerPool {
public:
    /// @param handle  called in a thread of the pool for each connection that was submitted
    HandlerPool(std::size_t most, NetLimits::Time idleTime,
                std::function<void(Connection&)> handle);
    ~HandlerPool() { stop(); }
    HandlerPool(const HandlerPool&) = delete;
    HandlerPool& operator=(const HandlerPool&) = delete;

    /// Puts a connection at the end of the queue.
    void submit(Connection& connection);
    /// Takes a connection out of the queue again. @return false if a thread already has it
    bool withdraw(const Connection& connection);
    /// Whether connections wait because the cap is reached.
    [[nodiscard]] bool crowded() const { return crowded_; }
    [[nodiscard]] std::size_t threads() const;
    /// Ends the threads, once the queue is empty.
    void stop();

private:
    void run();
    bool take(Connection*& connection);
    void joinEnded();

    const std::size_t most_;
    const NetLimits::Time idleTime_;
    const std::function<void(Connection&)> handle_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Connection*> queue_;
    std::map<std::thread::id, std::thread> threads_;
    std::vector<std::thread> ended_;
    std::size_t idle_ = 0;
    bool stopping_ = false;
    std::atomic<bool> crowded_{false};
};

}  // namespace rivage::server
