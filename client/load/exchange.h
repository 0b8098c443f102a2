#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "client/load/response_parser.h"

namespace rivage::client::load {

using Clock = std::chrono::steady_clock;
using TimePoint = Clock::time_point;

/// What went wrong between two machines, before anything that the answer says counts.
enum class Fault : std::uint8_t {
    none,
    notSent,  ///< there was no connection to send it on, and no room for another one
    connectRefused,
    connectTimeout,
    connectFailed,
    tlsFailed,
    resetBeforeResponse,
    resetMidBody,
    shortBody,  ///< the connection ended in good order, the body had not
    timeout,
    malformed,  ///< the answer is none of HTTP/1.1
    aborted,    ///< on purpose, by us
};

/// One request and its answer on one connection, with the times between.
struct Exchange {
    virtual ~Exchange() = default;
    std::string_view head;
    std::string_view body;
    Keep keep = Keep::errors;
    double bytesPerSecond = 0;  ///< of a slow client; 0: as fast as it goes
    bool streamed = false;      ///< the listener wants to see the body as it grows

    TimePoint begun;      ///< a connection was asked for
    TimePoint connected;  ///< equal to `begun` on a connection that was there
    TimePoint secured;
    TimePoint written;    ///< the last byte of the request has left
    TimePoint firstByte;  ///< of the answer
    TimePoint ended;
    bool reused = false;   ///< the connection was there
    bool retried = false;  ///< the connection that was there had just been closed by the server
    Fault fault = Fault::none;
    ResponseParser answer;
};

/// Who is told about exchanges.
class ExchangeListener {
public:
    virtual ~ExchangeListener() = default;
    /// More of the body of a streamed answer has come.
    virtual void grown(Exchange& exchange) = 0;
    /// The answer is whole, or `fault` says why not. A new exchange may be begun from here.
    virtual void ended(Exchange& exchange) = 0;
};

}  // namespace rivage::client::load
