#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "server/net/answer.h"
#include "server/net/front.h"
#include "tests/server/net/raw_client.h"

/// A front with a few handlers that show what connections do:
///   GET /quick         "quick"
///   GET /slow          "slow", when `open` is set; counts itself in `running`
///   GET /lent          `big`, lent; GET /copied: the same bytes, not lent
///   GET /watch         "gone" is counted when `clientLeft` says so
///   GET /stream        chunks for as long as the client takes them
///   POST /upload       the size of the body; 408 if it came too slowly
///   POST /refuse       403 without reading the body
namespace rivage::test {

class NetServer {
public:
    explicit NetServer(const server::NetLimits& limits = {},
                       const server::TlsContext* tls = nullptr);
    NetServer(const server::NetLimits& limits, server::Listener listener);
    ~NetServer() { stop(); }
    void stop() {
        open = true;
        front->stop();
    }

    [[nodiscard]] std::size_t count(server::Phase phase) const {
        return front->stats().count(phase);
    }
    /// Waits until so many connections are in a phase. @return false after 5 s
    [[nodiscard]] bool waitFor(server::Phase phase, std::size_t expected) const;

    std::atomic<bool> open{false};
    std::atomic<int> running{0};
    std::atomic<int> gone{0};
    std::atomic<int> refused{0};
    std::shared_ptr<const std::string> big =
        std::make_shared<const std::string>(std::size_t{32} << 20, 'b');
    server::HttpEngine engine;
    std::unique_ptr<server::Front> front;
    server::Address address;

private:
    void setRoutes();
    void setBigRoutes();
    void begin(const server::NetLimits& limits, server::Listener listener,
               const server::TlsContext* tls);
};

/// Waits until something holds. @return false after 5 s
bool eventually(const std::function<bool()>& holds);

/// Milliseconds that `GET /quick` takes on a connection of its own; a large number if it fails.
[[nodiscard]] double quickMilliseconds(const server::Address& address);

}  // namespace rivage::test
