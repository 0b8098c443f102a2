#include "client/load/carrier.h"

#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace rivage::client::load {
namespace {

using namespace std::chrono_literals;

/// How often timeouts and slow clients are looked at.
constexpr auto kSweepInterval = 20ms;
/// A slow client sends and reads so often.
constexpr auto kPace = 50ms;
/// The kernel wakes a thread late by about so much; the rest is waited for in a loop.
constexpr auto kWakeEarly = 60us;
constexpr std::size_t kBuffer = 256 << 10;
constexpr int kEvents = 256;
/// So many bytes of one connection are taken before the others have their turn.
constexpr std::size_t kFairShare = 1 << 20;

/// Watches a descriptor. @return 0, or errno
int watch(int epoll, int fd, std::uint32_t events, void* what) {
    epoll_event event{};
    event.events = events;
    event.data.ptr = what;
    return epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event) == 0 ? 0 : errno;
}

}  // namespace

void Shortage::note(int what) {
    if (count++ == 0) error = what;
}

void Shortage::merge(const Shortage& other) {
    if (count == 0) error = other.error;
    count += other.count;
}

Carrier::Carrier(const Target& target, CarrierLimits limits, ExchangeListener& listener)
    : target_(target),
      limits_(limits),
      listener_(listener),
      buffer_(kBuffer),
      nextSweep_(Clock::now()) {
    const int error = prepare();
    if (error != 0) shortage_.note(error);
    ready_ = error == 0;
}

/// @return 0, or errno
int Carrier::prepare() {
    epoll_ = epoll_create1(EPOLL_CLOEXEC);
    if (epoll_ < 0) return errno;
    timer_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    if (timer_ < 0) return errno;
    // Setting the timer anew clears it: it is never read.
    return watch(epoll_, timer_, EPOLLIN | EPOLLET, nullptr);
}

Carrier::~Carrier() {
    slots_.clear();
    if (timer_ >= 0) ::close(timer_);
    if (epoll_ >= 0) ::close(epoll_);
}

Fault Carrier::connectFault(int error) {
    switch (error) {
        case ECONNREFUSED:
        case ENOENT:
        case EAGAIN: return Fault::connectRefused;
        case ETIMEDOUT: return Fault::connectTimeout;
        case EMFILE:
        case ENFILE:
        case ENOMEM:
        case ENOBUFS:
        case ENOSPC:
        case EADDRNOTAVAIL:  // our own limits, not the server's
            shortage_.note(error);
            return Fault::notSent;
        default: return Fault::connectFailed;
    }
}

void Carrier::begin(Exchange& exchange) {
    exchange.begun = Clock::now();
    exchange.connected = exchange.secured = exchange.begun;
    exchange.written = exchange.firstByte = TimePoint{};
    exchange.fault = Fault::none;
    exchange.retried = false;
    exchange.answer.reset(exchange.keep, exchange.head.starts_with("HEAD "));
    Slot* slot = ready_ ? takeSlot() : nullptr;
    if (slot == nullptr) return report(exchange, Fault::notSent);
    slot->exchange = &exchange;
    slot->sent = 0;
    slot->paced = TimePoint{};
    ++active_;
    exchange.reused = slot->stage == Stage::idle;
    if (!exchange.reused) return open(*slot);
    slot->stage = Stage::sending;
    drive(*slot);
}

void Carrier::report(Exchange& exchange, Fault fault) {
    exchange.fault = fault;
    exchange.ended = Clock::now();
    listener_.ended(exchange);
}

Carrier::Slot* Carrier::takeSlot() {
    for (auto* list : {&idle_, &closed_}) {
        if (list->empty()) continue;
        Slot* slot = list->back();
        list->pop_back();
        return slot;
    }
    if (slots_.size() >= limits_.connections) return nullptr;
    slots_.push_back(std::make_unique<Slot>());
    return slots_.back().get();
}

void Carrier::open(Slot& slot) {
    const IoResult result = slot.wire.connect(target_);
    slot.interest = 0;
    if (result.io == Io::failed) return end(slot, connectFault(result.error));
    if (const int error = watch(epoll_, slot.wire.fd(), 0, &slot); error != 0)
        return end(slot, connectFault(error));
    ++opened_;
    slot.stage = Stage::connecting;
    if (result.io == Io::wantWrite) return hear(slot, EPOLLOUT);
    drive(slot);
}

void Carrier::hear(Slot& slot, std::uint32_t interest) {
    if (slot.interest == interest) return;
    slot.interest = interest;
    epoll_event event{};
    event.events = interest;
    event.data.ptr = &slot;
    epoll_ctl(epoll_, EPOLL_CTL_MOD, slot.wire.fd(), &event);
}

/// Goes on as far as it can. A step returns whether there may be another one: not if the socket is
/// not ready, and not if the exchange has ended, as its end may have begun the next.
void Carrier::drive(Slot& slot) {
    if (slot.stage == Stage::connecting && !stepConnect(slot)) return;
    if (slot.stage == Stage::handshake && !stepHandshake(slot)) return;
    if (slot.stage == Stage::sending) stepSend(slot);
}

bool Carrier::stepConnect(Slot& slot) {
    const IoResult result = slot.wire.finishConnect();
    if (result.io == Io::wantWrite) return false;
    if (result.io == Io::failed) {
        end(slot, connectFault(result.error));
        return false;
    }
    slot.exchange->connected = slot.exchange->secured = Clock::now();
    slot.stage = Stage::handshake;
    return true;
}

bool Carrier::stepHandshake(Slot& slot) {
    const IoResult result = slot.wire.handshake();
    if (result.io == Io::wantRead || result.io == Io::wantWrite) return blocked(slot, result.io);
    if (result.io != Io::done) {
        end(slot, Fault::tlsFailed);
        return false;
    }
    if (slot.wire.secure()) slot.exchange->secured = Clock::now();
    slot.stage = Stage::sending;
    return true;
}

bool Carrier::blocked(Slot& slot, Io io) {
    hear(slot, io == Io::wantWrite ? EPOLLIN | EPOLLOUT : EPOLLIN);
    return false;
}

/// Whether a slow client may send or read now; if not, it is woken by `sweep`.
bool Carrier::mayMove(Slot& slot) {
    const double rate = slot.exchange->bytesPerSecond;
    if (rate <= 0) return true;
    const TimePoint now = Clock::now();
    if (now < slot.paced) {
        hear(slot, 0);
        if (std::find(slow_.begin(), slow_.end(), &slot) == slow_.end()) slow_.push_back(&slot);
        return false;
    }
    slot.paced = now + kPace;
    slot.allowance = std::max<std::size_t>(
        1, static_cast<std::size_t>(rate * std::chrono::duration<double>(kPace).count()));
    return true;
}

void Carrier::stepSend(Slot& slot) {
    Exchange& exchange = *slot.exchange;
    const std::size_t total = exchange.head.size() + exchange.body.size();
    while (slot.sent < total) {
        if (!mayMove(slot)) return;
        std::array<iovec, 2> pieces{};
        std::size_t count = 0;
        std::size_t skip = slot.sent;
        for (std::string_view part : {exchange.head, exchange.body}) {
            const std::size_t left = part.size() - std::min(part.size(), skip);
            if (left > 0) pieces[count++] = {const_cast<char*>(part.end() - left), left};
            skip -= std::min(part.size(), skip);
        }
        if (exchange.bytesPerSecond > 0) {
            count = 1;
            pieces[0].iov_len = std::min(pieces[0].iov_len, slot.allowance);
        }
        const IoResult result = slot.wire.send({pieces.data(), count});
        if (result.io == Io::wantRead || result.io == Io::wantWrite) {
            (void)blocked(slot, result.io);
            return;
        }
        if (result.io != Io::done) {
            // The server may have refused without reading everything: its answer counts.
            slot.stage = Stage::receiving;
            return stepReceive(slot);
        }
        slot.sent += result.bytes;
        bytesOut_ += result.bytes;
    }
    exchange.written = Clock::now();
    slot.stage = Stage::receiving;
    hear(slot, EPOLLIN);
}

void Carrier::stepReceive(Slot& slot) {
    // A server that never stops sending must not keep the others, and the time limits, waiting.
    for (std::size_t taken = 0; taken < kFairShare && mayMove(slot);) {
        std::span<char> room(buffer_);
        if (slot.exchange->bytesPerSecond > 0)
            room = room.first(std::min(room.size(), slot.allowance));
        const IoResult result = slot.wire.receive(room);
        if (result.io == Io::wantRead || result.io == Io::wantWrite) {
            if (slot.stage != Stage::sending) (void)blocked(slot, result.io);
            return;
        }
        if (result.io != Io::done) return broken(slot, result);
        taken += result.bytes;
        if (!take(slot, {room.data(), result.bytes})) return;
        if (!slot.wire.secure() && result.bytes < room.size()) return;
    }
}

/// @return whether the exchange goes on
bool Carrier::take(Slot& slot, std::string_view bytes) {
    Exchange& exchange = *slot.exchange;
    bytesIn_ += bytes.size();
    if (exchange.firstByte == TimePoint{}) exchange.firstByte = Clock::now();
    const std::uint64_t before = exchange.answer.bodySize();
    const std::size_t used = exchange.answer.feed(bytes);
    if (exchange.streamed && exchange.answer.bodySize() != before) {
        const std::uint64_t epoch = slot.epoch;
        listener_.grown(exchange);
        if (slot.epoch != epoch) return false;  // the listener has broken it off
    }
    if (!exchange.answer.done() && !exchange.answer.malformed()) return true;
    if (used < bytes.size()) (void)exchange.answer.finish();  // nobody asked for more
    end(slot, exchange.answer.malformed() ? Fault::malformed : Fault::none);
    return false;
}

/// The connection has ended, in good order or not, before the answer was known to be whole.
void Carrier::broken(Slot& slot, const IoResult& result) {
    Exchange& exchange = *slot.exchange;
    const bool silent = exchange.firstByte == TimePoint{};
    if (silent && exchange.reused && !exchange.retried) {
        // The server closed an idle connection while the request was under way.
        exchange.retried = true;
        exchange.reused = false;
        slot.wire.close();
        slot.sent = 0;
        exchange.written = TimePoint{};
        exchange.connected = exchange.secured = exchange.begun;
        open(slot);
        return;
    }
    if (result.io == Io::closed && exchange.answer.finish()) return end(slot, Fault::none);
    if (exchange.answer.status() == 0) return end(slot, Fault::resetBeforeResponse);
    end(slot, result.io == Io::closed ? Fault::shortBody : Fault::resetMidBody);
}

void Carrier::end(Slot& slot, Fault fault) {
    Exchange& exchange = *slot.exchange;
    const bool whole = slot.sent == exchange.head.size() + exchange.body.size();
    slot.exchange = nullptr;
    ++slot.epoch;
    --active_;
    if (fault == Fault::none && whole && exchange.answer.reusable() && limits_.keepAlive) {
        slot.stage = Stage::idle;
        hear(slot, EPOLLIN);
        idle_.push_back(&slot);
    } else {
        drop(slot);
    }
    report(exchange, fault);
}

void Carrier::drop(Slot& slot) {
    slot.wire.close();
    slot.stage = Stage::closed;
    slot.interest = 0;
    std::erase(slow_, &slot);
    closed_.push_back(&slot);
}

void Carrier::abort(Exchange& exchange) {
    for (const auto& slot : slots_)
        if (slot->exchange == &exchange) return end(*slot, Fault::aborted);
}

/// An idle connection has something to say: usually that the server has closed it.
void Carrier::watchIdle(Slot& slot) {
    const IoResult result = slot.wire.receive(buffer_);
    if (result.io == Io::wantRead) return;  // a message of TLS itself
    std::erase(idle_, &slot);
    drop(slot);
}

void Carrier::sweep(TimePoint now) {
    nextSweep_ = now + kSweepInterval;
    for (std::size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = *slots_[i];
        if (slot.exchange == nullptr) continue;
        const auto age = now - slot.exchange->begun;
        const bool connecting = slot.stage == Stage::connecting || slot.stage == Stage::handshake;
        if (connecting && age > limits_.connectTimeout)
            end(slot, Fault::connectTimeout);
        else if (age > limits_.timeout)
            end(slot, Fault::timeout);
    }
    for (Slot* slot : std::vector<Slot*>(std::exchange(slow_, {}))) {
        if (slot->exchange == nullptr) continue;
        if (slot->stage == Stage::sending)
            stepSend(*slot);
        else
            stepReceive(*slot);
    }
}

void Carrier::setTimer(TimePoint until) {
    if (until == armed_) return;
    armed_ = until;
    const auto count =
        std::chrono::duration_cast<std::chrono::nanoseconds>(until.time_since_epoch());
    itimerspec spec{};
    spec.it_value.tv_sec = count.count() / 1'000'000'000;
    spec.it_value.tv_nsec = count.count() % 1'000'000'000;
    timerfd_settime(timer_, TFD_TIMER_ABSTIME, &spec, nullptr);
}

void Carrier::react(Slot& slot, std::uint32_t events) {
    if (slot.stage == Stage::closed) return;
    if (slot.stage == Stage::idle) return watchIdle(slot);
    // A pause of a slow client ends when there is nothing left to wait for.
    if ((events & (EPOLLHUP | EPOLLERR)) != 0) slot.paced = TimePoint{};
    if (slot.stage == Stage::receiving) return stepReceive(slot);
    const std::uint64_t epoch = slot.epoch;
    if (slot.stage == Stage::sending && (events & EPOLLIN) != 0) stepReceive(slot);
    if (slot.epoch == epoch) drive(slot);
}

bool Carrier::poll(TimePoint until) {
    TimePoint now = Clock::now();
    const TimePoint wake = std::min(until, nextSweep_) - kWakeEarly;
    const bool sleeps = wake > now + kWakeEarly;
    if (sleeps) setTimer(wake);
    std::array<epoll_event, kEvents> events{};
    const int count = epoll_wait(epoll_, events.data(), kEvents, sleeps ? -1 : 0);
    for (int i = 0; i < count; ++i) {
        auto* slot = static_cast<Slot*>(events[i].data.ptr);
        if (slot != nullptr) react(*slot, events[i].events);
    }
    now = Clock::now();
    if (now >= nextSweep_) sweep(now);
    return sleeps || count > 0;
}

}  // namespace rivage::client::load
