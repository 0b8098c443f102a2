#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <unordered_map>

namespace rivage::client::load {

struct StubSettings {
    int port = 0;                       ///< 0: a free one
    std::size_t bodySize = 2;           ///< bytes of each answer
    std::chrono::microseconds work{0};  ///< processor time of each answer
    /// After so many seconds from the first request the server stands still ...
    std::chrono::duration<double> stallAt{0};
    std::chrono::duration<double> stallFor{0};  ///< ... for so long; 0: never
};

/// A small HTTP server that answers every request with the same 200 at once, from one thread, on
/// loopback: what a generator can be measured against. It reads no bodies.
class StubServer {
public:
    explicit StubServer(const StubSettings& settings);
    ~StubServer();
    StubServer(const StubServer&) = delete;
    StubServer& operator=(const StubServer&) = delete;

    /// 0 if it could not listen.
    [[nodiscard]] int port() const { return port_; }
    [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }
    [[nodiscard]] std::uint64_t answered() const { return answered_; }

private:
    void serve();
    void admit();
    void answer(int client);
    void standStill();
    void work() const;

    StubSettings settings_;
    std::string answer_;
    int listener_ = -1;
    int epoll_ = -1;
    int end_ = -1;  ///< eventfd, written by the destructor
    int port_ = 0;
    bool stalled_ = false;
    std::chrono::steady_clock::time_point first_;
    std::unordered_map<int, std::string> pending_;  ///< heads that are not whole yet
    std::atomic<std::uint64_t> answered_{0};
    std::thread thread_;
};

}  // namespace rivage::client::load
