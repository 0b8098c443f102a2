#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "client/load/exchange.h"
#include "client/load/wire.h"

namespace rivage::client::load {

struct CarrierLimits {
    std::size_t connections = 1000;  ///< at a time
    std::chrono::milliseconds connectTimeout{5000};
    std::chrono::milliseconds timeout{30'000};  ///< from the beginning of an exchange to its end
    bool keepAlive = true;                      ///< false: a connection for each exchange
};

/// What this machine, and not the server, had too little of.
struct Shortage {
    int error = 0;            ///< errno of the first time: EMFILE, ENFILE, EADDRNOTAVAIL, ...
    std::uint64_t count = 0;  ///< how often
    void note(int what);
    void merge(const Shortage& other);
};

/// Carries exchanges over connections of its own, with one epoll and without ever waiting for one
/// of them. Belongs to one thread.
class Carrier {
public:
    Carrier(const Target& target, CarrierLimits limits, ExchangeListener& listener);
    ~Carrier();
    Carrier(const Carrier&) = delete;
    Carrier& operator=(const Carrier&) = delete;

    /// Begins an exchange, which must live until the listener is told of its end. It is told at
    /// once, from here, if it cannot be begun.
    void begin(Exchange& exchange);
    /// Breaks an exchange off; the listener is told, with `Fault::aborted`.
    void abort(Exchange& exchange);
    /// Sleeps until something can be done, or until `until`, and does it. What is nearer than the
    /// kernel wakes a thread is not slept for.
    /// @return false if it neither slept nor did anything
    bool poll(TimePoint until);

    /// Whether it can carry anything at all; if not, `shortage` says why.
    [[nodiscard]] bool ready() const { return ready_; }
    [[nodiscard]] const Shortage& shortage() const { return shortage_; }
    [[nodiscard]] std::size_t active() const { return active_; }
    [[nodiscard]] std::uint64_t opened() const { return opened_; }
    [[nodiscard]] std::uint64_t bytesIn() const { return bytesIn_; }
    [[nodiscard]] std::uint64_t bytesOut() const { return bytesOut_; }

private:
    enum class Stage : std::uint8_t { closed, connecting, handshake, idle, sending, receiving };
    struct Slot {
        Wire wire;
        Stage stage = Stage::closed;
        std::uint32_t interest = 0;
        std::size_t sent = 0;  ///< of head and body
        Exchange* exchange = nullptr;
        TimePoint paced;  ///< when a slow client moves again
        std::size_t allowance = 0;
        std::uint64_t epoch = 0;  ///< counts the exchanges that have ended
    };

    int prepare();
    Slot* takeSlot();
    void open(Slot& slot);
    void react(Slot& slot, std::uint32_t events);
    void drive(Slot& slot);
    bool stepConnect(Slot& slot);
    bool stepHandshake(Slot& slot);
    void stepSend(Slot& slot);
    void stepReceive(Slot& slot);
    bool take(Slot& slot, std::string_view bytes);
    bool blocked(Slot& slot, Io io);
    bool mayMove(Slot& slot);
    void hear(Slot& slot, std::uint32_t interest);
    void watchIdle(Slot& slot);
    void broken(Slot& slot, const IoResult& result);
    void end(Slot& slot, Fault fault);
    void drop(Slot& slot);
    void sweep(TimePoint now);
    void setTimer(TimePoint until);
    void report(Exchange& exchange, Fault fault);
    Fault connectFault(int error);

    const Target& target_;
    const CarrierLimits limits_;
    ExchangeListener& listener_;
    int epoll_ = -1;
    int timer_ = -1;
    bool ready_ = false;
    Shortage shortage_;
    std::vector<std::unique_ptr<Slot>> slots_;
    std::vector<Slot*> idle_;
    std::vector<Slot*> closed_;
    std::vector<Slot*> slow_;
    std::vector<char> buffer_;
    std::size_t active_ = 0;
    std::uint64_t opened_ = 0;
    std::uint64_t bytesIn_ = 0;
    std::uint64_t bytesOut_ = 0;
    TimePoint nextSweep_;
    TimePoint armed_;
};

}  // namespace rivage::client::load
