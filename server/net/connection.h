#pragma once

#include <string>
#include <utility>

#include "server/net/channel.h"
#include "server/net/head_scanner.h"
#include "server/net/net_stats.h"
#include "server/net/output.h"
#include "server/net/rate_guard.h"

namespace rivage::server {

/// Where a connection is, as its front sees it.
enum class Place : std::uint8_t { handshake, head, idle, handler, tail, linger };

/// One client. At any time one thread owns it: the front, or the handler thread it was handed to.
/// The change of owner goes through a mutex, so nothing here needs one.
struct Connection {
    Connection(Fd fd, SslPointer ssl, NetStats& stats)
        : channel(std::move(fd), std::move(ssl)), mark(stats) {}

    Channel channel;
    std::string host;  ///< of the peer; empty on a Unix socket
    int port = 0;

    std::string in;       ///< received and not used yet
    HeadScanner scanner;  ///< of the head at the start of `in`
    Output out;           ///< not taken by the client yet
    std::size_t requests = 0;
    bool keep = true;     ///< another request may follow what is in `out`
    bool failed = false;  ///< broken: nothing more can be sent
    PhaseMark mark;

    /// Bytes of answers that have reached the client.
    [[nodiscard]] std::int64_t delivered() const {
        return static_cast<std::int64_t>(out.sent()) -
               static_cast<std::int64_t>(channel.unconfirmed());
    }

    /// Looks for a head at the start of what has come.
    HeadVerdict scan(const NetLimits& limits) {
        while (scanner.size() == 0 && in.starts_with("\r\n")) in.erase(0, 2);  // RFC 9112, 2.2
        if (in == "\r") return {};
        return scanner.scan(in, limits);
    }

    // Only the front touches these, also while a handler thread has the connection.
    Place place = Place::head;
    NetClock::time_point deadline = {};
    RateGuard guard{{}, 0, {}, 0};
    std::size_t discarded = 0;
    bool watched = false;  ///< known to epoll
};

}  // namespace rivage::server
