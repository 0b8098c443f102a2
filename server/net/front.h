#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "proto/problem.h"
#include "server/net/acceptor.h"
#include "server/net/connection.h"
#include "server/net/handler_pool.h"
#include "server/net/http_engine.h"

namespace rivage::server {

/// The connections of one server. One thread accepts them and holds all that have nothing to do:
/// idle, in a handshake, with half a request head, with an answer that the client takes slowly, or
/// waiting to be closed. A connection is handed to a thread of the pool only with a complete head.
class Front {
public:
    /// Called in the front's thread with each answer that no handler gave.
    using Refused = std::function<void(int status, const std::string& requestId)>;

    /// @param engine  must outlive the front
    Front(NetLimits limits, HttpEngine& engine, Refused refused = {});
    ~Front();

    /// Serves from a thread of its own.
    /// @param tls  null for plain HTTP; else it must outlive the front
    /// @errors internal if the system has no descriptors left
    core::Result<void> start(Listener listener, const TlsContext* tls = nullptr);

    /// Accepts nothing more (new connections wait in the kernel, for another process that shares
    /// the listener), lets the answers under way end within `stopTimeout`, then breaks off.
    void stop();

    [[nodiscard]] const NetStats& stats() const { return stats_; }
    [[nodiscard]] std::size_t handlerThreads() const { return pool_.threads(); }
    /// When the front's thread was last seen to be alive: at most about 0.1 s ago.
    [[nodiscard]] NetClock::time_point lastBeat() const {
        return NetClock::time_point(NetClock::duration(beat_.load()));
    }

private:
    // In the front's thread.
    void run();
    void beat(NetClock::time_point now);
    void acceptAll();
    void pollListener(bool on);
    void welcome(Accepted accepted);
    void onReady(Connection& connection);
    void onHandshake(Connection& connection);
    void onReadable(Connection& connection);
    bool goesOnReading(Connection& connection);
    void onReturned(Connection& connection);
    void resume(Connection& connection);
    void beginTail(Connection& connection);
    void sendTail(Connection& connection);
    void linger(Connection& connection);
    void beginLinger(Connection& connection);
    void refuse(Connection& connection, const proto::Problem& problem);
    void onDeadline(Connection& connection, NetClock::time_point now);
    void sweep(NetClock::time_point now);
    void sweepAtStop(NetClock::time_point now);
    void arm(Connection& connection, IoStatus wanted);
    void enter(Connection& connection, Place place, NetLimits::Time timeout);
    void close(Connection& connection);
    void takeReturned();
    // In a handler thread.
    void handle(Connection& connection);
    bool nextIsHere(Connection& connection);

    const NetLimits limits_;
    HttpEngine& engine_;
    const Refused refused_;
    NetStats stats_;
    std::optional<Acceptor> acceptor_;
    const TlsContext* tls_ = nullptr;
    Fd epoll_;
    Fd wake_;
    std::unordered_map<Connection*, std::unique_ptr<Connection>> connections_;
    std::vector<char> scratch_;
    NetClock::time_point nextSweep_ = {};
    NetClock::time_point stopBegan_ = {};
    bool accepting_ = false;
    bool broken_ = false;  ///< `stopTimeout` is over

    std::atomic<bool> stopping_{false};
    std::atomic<NetClock::rep> beat_{0};
    std::mutex mutex_;
    std::vector<Connection*> returned_;  ///< guarded by `mutex_`
    HandlerPool pool_;
    std::thread thread_;
};

}  // namespace rivage::server
