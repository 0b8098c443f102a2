#pragma once

#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <string_view>

#include "client/endpoint.h"
#include "client/failure.h"
#include "client/interrupt.h"

namespace rivage::client {

using Clock = std::chrono::steady_clock;

/// How often and how long to try. The delay before try n is drawn from [0, base * 2^n), at most
/// `cap`, on top of what `Retry-After` asks for.
struct RetryPolicy {
    std::chrono::milliseconds base{250};
    std::chrono::milliseconds cap{10'000};
    int connectTries = 5;  ///< a full server is asked until the deadline, an absent one is not
};

/// Where the body of a successful answer goes, instead of into memory.
struct BodySink {
    std::function<bool()> restart;                ///< forget what came: the request is tried again
    std::function<bool(std::string_view)> write;  ///< false gives up
};

/// Sends requests to one server, each at its own connection, and tries again where that is right:
/// what could not connect; 408, 429, 502, 503, 504; and broken connections if the method is safe to
/// repeat. Each thread needs its own.
class Transport {
public:
    Transport(ServerAccess server, Interrupt& interrupt, RetryPolicy policy = {});

    /// The time by which everything has to be over, tries and waiting included.
    void setDeadline(Clock::time_point deadline) { deadline_ = deadline; }

    /// Sends a request until it has an answer that is not worth another try.
    /// @return  an answer with a status below 400
    /// @errors  unreachable; busy if the time is over or the server stays full; cancelled; else
    ///          what the server's problem means
    Outcome<httplib::Response> send(const httplib::Request& request,
                                    const BodySink* sink = nullptr);

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
    Answer sendOnce(httplib::Request request, const BodySink* sink);
    bool worthAnotherTry(const httplib::Request& request, const Answer& answer, int tries) const;
    [[nodiscard]] Failure failureOf(const Answer& answer) const;
    std::chrono::milliseconds delay(const Answer& answer, int tries);

    ServerAccess server_;
    Interrupt& interrupt_;
    RetryPolicy policy_;
    Clock::time_point deadline_ = Clock::time_point::max();
    std::mt19937_64 random_;
};

/// A request without body.
[[nodiscard]] httplib::Request makeRequest(std::string method, std::string path);

}  // namespace rivage::client
