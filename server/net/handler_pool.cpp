#include "server/net/handler_pool.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace rivage::server {

HandlerPool::HandlerPool(std::size_t most, NetLimits::Time idleTime,
                         std::function<void(Connection&)> handle)
    : most_(most), idleTime_(idleTime), handle_(std::move(handle)) {}

void HandlerPool::submit(Connection& connection) {
    {
        const std::lock_guard lock(mutex_);
        queue_.push_back(&connection);
        // A thread that was woken counts as idle until it has taken its connection, and so does
        // the connection as waiting: the comparison holds at every moment.
        if (queue_.size() > idle_ && threads_.size() < most_) {
            try {
                std::thread thread([this] { run(); });
                const std::thread::id id = thread.get_id();
                threads_.emplace(id, std::move(thread));
            } catch (const std::system_error&) {
                // No thread is left in the system: this connection waits as at the cap.
            }
        }
        crowded_ = queue_.size() > idle_ && threads_.size() >= most_;
        joinEnded();
    }
    changed_.notify_one();
}

bool HandlerPool::withdraw(const Connection& connection) {
    const std::lock_guard lock(mutex_);
    const auto found = std::find(queue_.begin(), queue_.end(), &connection);
    if (found == queue_.end()) return false;
    queue_.erase(found);
    crowded_ = queue_.size() > idle_;
    return true;
}

std::size_t HandlerPool::threads() const {
    const std::lock_guard lock(mutex_);
    return threads_.size();
}

/// Waits for the next connection. @return false if the thread shall end
bool HandlerPool::take(Connection*& connection) {
    std::unique_lock lock(mutex_);
    ++idle_;
    changed_.wait_for(lock, idleTime_, [&] { return !queue_.empty() || stopping_; });
    --idle_;
    if (queue_.empty()) {
        const auto self = threads_.find(std::this_thread::get_id());
        if (stopping_) return false;  // `stop` joins all that are left
        ended_.push_back(std::move(self->second));
        threads_.erase(self);
        return false;
    }
    connection = queue_.front();
    queue_.pop_front();
    crowded_ = queue_.size() > idle_;
    return true;
}

void HandlerPool::run() {
    Connection* connection = nullptr;
    while (take(connection)) handle_(*connection);
}

/// Joins threads that have nothing left to do but to return.
void HandlerPool::joinEnded() {
    for (std::thread& thread : ended_) thread.join();
    ended_.clear();
}

void HandlerPool::stop() {
    std::map<std::thread::id, std::thread> threads;
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        threads.swap(threads_);
        joinEnded();
    }
    changed_.notify_all();
    for (auto& [id, thread] : threads) thread.join();
}

}  // namespace rivage::server
