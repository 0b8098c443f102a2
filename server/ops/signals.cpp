#include "server/ops/signals.h"

#include <algorithm>
#include <utility>

namespace rivage::server {
namespace {

/// Real-time signals queue, and carry a number: the signal that is sent on.
int carrier() { return SIGRTMIN; }

}  // namespace

sigset_t handledSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
    return signals;
}

sigset_t servingSignals() {
    sigset_t signals = handledSignals();
    sigaddset(&signals, carrier());
    return signals;
}

void sendOn(pid_t serving, int signal) {
    ::sigqueue(serving, carrier(), sigval{.sival_int = signal});
}

SignalRequest SignalReader::next(std::chrono::milliseconds wait) {
    const sigset_t signals = servingSignals();
    const auto until = std::chrono::steady_clock::now() + wait;
    while (true) {
        const auto left =
            std::max(std::chrono::nanoseconds(0),
                     std::chrono::nanoseconds(until - std::chrono::steady_clock::now()));
        const timespec time{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
        siginfo_t info{};
        const int taken = ::sigtimedwait(&signals, &info, &time);
        const bool isSentOn = taken == carrier();
        const int signal = isSentOn ? info.si_value.sival_int : taken;
        if (signal == SIGHUP) return SignalRequest::reload;
        if (signal == SIGTERM || signal == SIGINT) {
            ++(isSentOn ? sentOn_ : direct_);
            const int before = std::exchange(stops_, std::max(sentOn_, direct_));
            if (stops_ > before)
                return stops_ > 1          ? SignalRequest::end
                       : signal == SIGTERM ? SignalRequest::stop
                                           : SignalRequest::stopSoon;
        }
        if (std::chrono::steady_clock::now() >= until) return SignalRequest::none;
    }
}

}  // namespace rivage::server
