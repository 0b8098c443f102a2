#pragma once

#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>

#include "client/endpoint.h"
#include "client/failure.h"
#include "client/interrupt.h"
#include "client/retry.h"

namespace rivage::client {

using Clock = std::chrono::steady_clock;

/// Where the body of a successful answer goes, instead of into memory. It may stay together over
/// several tries, each of which asks for what is still missing.
class BodySink {
public:
    virtual ~BodySink() = default;
    /// Before every try: asks for what is missing.
    virtual void prepare(httplib::Request& request) = 0;
    /// The head of an answer with status 200 or 206; false gives up.
    virtual bool begin(const httplib::Response& head) = 0;
    /// The next bytes; false gives up.
    virtual bool write(std::string_view bytes) = 0;
    /// An answer without the part that was asked for (416): drops all; false gives up.
    virtual bool restart() = 0;
    /// Bytes that are kept. A try that brought some does not count as one in vain.
    [[nodiscard]] virtual std::uint64_t received() const = 0;
};

struct SendOptions {
    BodySink* sink = nullptr;
    bool patient = false;  ///< a job of ours is at the server
};

/// Sends requests to one server, each at its own connection, and tries again where that is right:
/// what could not connect; 408, 429, 502, 503, 504; and broken connections if the method is safe to
/// repeat or the request has an Idempotency-Key. Each thread needs its own.
class Transport {
public:
    Transport(ServerAccess server, Interrupt& interrupt, RetryPolicy policy = {});

    /// The time by which everything has to be over, tries and waiting included.
    void setDeadline(Clock::time_point deadline) { deadline_ = deadline; }

    /// Sends a request until it has an answer that is not worth another try.
    /// @return  an answer with a status below 300
    /// @errors  unreachable; busy if the time is over or the server stays full; cancelled; else
    ///          what the server's problem means
    Outcome<httplib::Response> send(const httplib::Request& request,
                                    const SendOptions& options = {});

    /// Sends a request once, within `patience`, even after a stop was asked for: for giving up a
    /// job. The answer does not matter.
    void sendAtLast(httplib::Request request, std::chrono::milliseconds patience);

    [[nodiscard]] const Interrupt& interrupt() const { return interrupt_; }

private:
    struct Answer {
        httplib::Error error = httplib::Error::Success;
        httplib::Response response;
    };
    httplib::Client makeClient() const;
    Answer sendOnce(httplib::Request request, BodySink* sink);
    [[nodiscard]] Failure failureOf(const Answer& answer) const;
    /// Waits before the next try; why not, if there is none.
    std::optional<Failure> waitToRetry(const Answer& answer, int tries, Failure failure);

    ServerAccess server_;
    Interrupt& interrupt_;
    RetryPolicy policy_;
    Clock::time_point deadline_ = Clock::time_point::max();
    std::mt19937_64 random_;
};

/// A request without body.
[[nodiscard]] httplib::Request makeRequest(std::string method, std::string path);

}  // namespace rivage::client
