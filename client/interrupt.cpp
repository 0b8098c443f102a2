#include "client/interrupt.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <utility>

namespace rivage::client {
namespace {

/// A stop that comes so much later is another one: some send theirs twice.
constexpr std::chrono::milliseconds kSecondSignal{250};

sigset_t stopSignals() {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
    return set;
}

/// The program ends by the signal, as one that does not handle it.
void endBy(int signal) {
    std::signal(signal, SIG_DFL);
    const sigset_t set = stopSignals();
    pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
    ::raise(signal);
}

}  // namespace

void Interrupt::request() {
    const std::lock_guard lock(mutex_);
    requested_ = true;
    changed_.notify_all();
    for (const auto& breakOff : breaks_) breakOff();
}

bool Interrupt::requested() const {
    const std::lock_guard lock(mutex_);
    return requested_;
}

bool Interrupt::sleep(std::chrono::milliseconds duration) const {
    std::unique_lock lock(mutex_);
    return !changed_.wait_for(lock, duration, [&] { return requested_; });
}

bool Interrupt::await(int file, short events) const {
    constexpr int kLook = 50;  // milliseconds: nobody notices so long a delay of a stop
    while (!requested()) {
        pollfd wanted{file, events, 0};
        if (poll(&wanted, 1, kLook) != 0) return true;
    }
    return false;
}

BreakOff::BreakOff(Interrupt& interrupt, std::function<void()> action) : interrupt_(interrupt) {
    const std::lock_guard lock(interrupt_.mutex_);
    place_ = interrupt_.breaks_.insert(interrupt_.breaks_.end(), std::move(action));
}

BreakOff::~BreakOff() {
    const std::lock_guard lock(interrupt_.mutex_);
    interrupt_.breaks_.erase(place_);
}

SignalWatcher::SignalWatcher(Interrupt& interrupt) {
    const sigset_t set = stopSignals();
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    signals_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    end_ = eventfd(0, EFD_CLOEXEC);
    thread_ = std::thread([this, &interrupt] { watch(interrupt); });
}

SignalWatcher::~SignalWatcher() {
    eventfd_write(end_, 1);
    thread_.join();
    close(signals_);
    close(end_);
}

void SignalWatcher::watch(Interrupt& interrupt) const {
    std::chrono::steady_clock::time_point first;
    std::array<pollfd, 2> files{{{signals_, POLLIN, 0}, {end_, POLLIN, 0}}};
    for (;;) {
        // A stop may come just before the request that it has to break off has a connection, so
        // it is repeated until the run is over.
        const int patience = interrupt.requested() ? 50 : -1;
        if (poll(files.data(), files.size(), patience) < 0) continue;
        if (files[1].revents != 0) return;
        signalfd_siginfo info;
        const bool signalled = read(signals_, &info, sizeof info) == sizeof info;
        const auto now = std::chrono::steady_clock::now();
        if (signalled && !interrupt.requested()) first = now;
        if (signalled && now - first > kSecondSignal) endBy(static_cast<int>(info.ssi_signo));
        if (signalled || interrupt.requested()) interrupt.request();
    }
}

}  // namespace rivage::client
