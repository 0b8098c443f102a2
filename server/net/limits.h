#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace rivage::server {

/// What a connection may take of the server, in time and bytes.
struct NetLimits {
    using Time = std::chrono::milliseconds;

    std::size_t connections = 1024;  ///< open at a time; more are answered 503
    std::size_t handlers = 256;      ///< requests being answered at a time; more wait in order
    std::size_t requestsPerConnection = 1000;
    std::size_t lineBytes = 8 << 10;  ///< of the request line (414) or of one header (431)
    std::size_t headBytes = 32 << 10;
    std::size_t headers = 100;
    Time headTimeout{10000};   ///< for a whole head, from the connection or its first byte on
    Time bodyTimeout{300000};  ///< for a whole body
    std::uint64_t bodyBytes = ~std::uint64_t{0};  ///< of a body with its chunks and trailers
    Time bodyGrace{10000};           ///< window in which a body must come at the least rate
    Time writeGrace{10000};          ///< window in which an answer must be taken at the least rate
    std::uint64_t leastRate = 1024;  ///< bytes per second, over each window
    Time idleTimeout{65000};         ///< between requests; above the 60 s of usual balancers
    Time waitTimeout{5000};          ///< for a handler; then 503
    Time stopTimeout{30000};         ///< for answers under way when the server stops
    Time farewell{200};  ///< at a stop, for a request that is on its way on an idle connection
    Time lingerTimeout{2000};           ///< for the client to close after the last answer
    std::size_t lingerBytes = 1 << 20;  ///< thrown away meanwhile; then the client is held back
    Time spin{10};  ///< a handler stays with its connection so long: the next request often comes
    Time handlerIdle{5000};              ///< then a handler thread ends
    std::size_t copiedBytes = 64 << 10;  ///< of an answer that the client has not taken yet
};

}  // namespace rivage::server
