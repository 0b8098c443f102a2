#include "server/ops/signals.h"

#include <algorithm>
#include <utility>

namespace rivage::server {

sigset_t handledSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
    return signals;
}

SignalRequest SignalReader::next(std::chrono::milliseconds wait) {
    const sigset_t signals = handledSignals();
    const auto until = std::chrono::steady_clock::now() + wait;
    while (true) {
        const auto left =
            std::max(std::chrono::nanoseconds(0),
                     std::chrono::nanoseconds(until - std::chrono::steady_clock::now()));
        const timespec time{left.count() / 1'000'000'000, left.count() % 1'000'000'000};
        siginfo_t info{};
        const int signal = ::sigtimedwait(&signals, &info, &time);
        if (signal == SIGHUP) return SignalRequest::reload;
        if (signal > 0) {
            ++(supervisor_ > 0 && info.si_pid == supervisor_ ? fromSupervisor_ : fromOthers_);
            const int before = std::exchange(stops_, std::max(fromSupervisor_, fromOthers_));
            if (stops_ > before)
                return stops_ > 1          ? SignalRequest::end
                       : signal == SIGTERM ? SignalRequest::stop
                                           : SignalRequest::stopSoon;
        }
        if (std::chrono::steady_clock::now() >= until) return SignalRequest::none;
    }
}

}  // namespace rivage::server
