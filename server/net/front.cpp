#include "server/net/front.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <utility>

#include "server/net/canned.h"

namespace rivage::server {
namespace {

using namespace std::chrono_literals;
using core::ErrorCode;

constexpr std::size_t kReadSize = 16 << 10;
/// How often time limits are looked at.
constexpr auto kTick = 50ms;
/// Accepted in a row, before other connections have their turn.
constexpr int kAcceptBurst = 64;
/// Sent to one client, before other connections have their turn.
constexpr std::size_t kTurn = 1 << 20;
/// Refused connections that may wait for their clients to close; beyond, they are cut off.
constexpr std::size_t kMaxRefused = 256;

Phase phaseOf(Place place) {
    switch (place) {
        case Place::handshake:
        case Place::head: return Phase::header;
        case Place::idle: return Phase::idle;
        case Place::handler: return Phase::handler;
        case Place::tail: return Phase::stream;
        case Place::linger: return Phase::closing;
    }
    return Phase::closing;
}

bool isAnswering(Place place) { return place == Place::handler || place == Place::tail; }

proto::Problem refusalProblem(const HeadVerdict& verdict) {
    proto::Problem problem{proto::transportProblemType(verdict.status)};
    if (verdict.limit > 0) problem.limit = verdict.limit;
    return problem;
}

proto::Problem full(const std::string& what, const std::string& setting) {
    core::Error error{ErrorCode::busy, what};
    error.setting = setting;
    return proto::makeProblem(error);
}

}  // namespace

Front::Front(NetLimits limits, HttpEngine& engine, Refused refused)
    : limits_(limits),
      engine_(engine),
      refused_(std::move(refused)),
      scratch_(kReadSize),
      pool_(limits.handlers, limits.handlerIdle,
            [this](Connection& connection) { handle(connection); }) {}

Front::~Front() { stop(); }

core::Result<void> Front::start(Listener listener, const TlsContext* tls) {
    acceptor_.emplace(std::move(listener));
    tls_ = tls;
    epoll_ = Fd(::epoll_create1(EPOLL_CLOEXEC));
    wake_ = Fd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    epoll_event wake{EPOLLIN, {&wake_}};
    epoll_event incoming{EPOLLIN, {&acceptor_}};
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, wake_.get(), &wake) != 0 ||
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, acceptor_->fd(), &incoming) != 0)
        return core::fail(ErrorCode::internal, "no file descriptor is left to listen with");
    accepting_ = true;
    beat(NetClock::now());
    thread_ = std::thread([this] { run(); });
    return {};
}

void Front::stop() {
    if (!thread_.joinable()) return;
    stopping_ = true;
    ::eventfd_write(wake_.get(), 1);
    thread_.join();
    pool_.stop();
}

void Front::beat(NetClock::time_point now) { beat_ = now.time_since_epoch().count(); }

void Front::run() {
    std::array<epoll_event, 64> events;
    while (!stopping_ || accepting_ || !connections_.empty()) {
        const int count = ::epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()),
                                       static_cast<int>(kTick.count()));
        bool woken = false;
        for (int i = 0; i < count; ++i) {
            void* target = events[static_cast<std::size_t>(i)].data.ptr;
            if (target == &wake_)
                woken = true;
            else if (target == &acceptor_)
                acceptAll();
            else
                onReady(*static_cast<Connection*>(target));
        }
        if (woken) takeReturned();
        const auto now = NetClock::now();
        beat(now);
        if (now >= nextSweep_) sweep(now);
    }
}

void Front::acceptAll() {
    for (int i = 0; i < kAcceptBurst && !stopping_; ++i) {
        auto accepted = acceptor_->next();
        if (acceptor_->exhausted()) pollListener(false);  // until the next sweep
        if (!accepted) return;
        welcome(*std::move(accepted));
    }
}

void Front::pollListener(bool on) {
    epoll_event event{on ? EPOLLIN : 0U, {&acceptor_}};
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, acceptor_->fd(), &event);
}

/// Takes a connection in, or refuses it. Refused ones do not count against the cap.
void Front::welcome(Accepted accepted) {
    ++stats_.accepted;
    const std::size_t refusals = stats_.count(Phase::closing);
    const bool crowded = connections_.size() >= limits_.connections + refusals;
    if (crowded && (tls_ || refusals >= kMaxRefused)) {
        ++stats_.refused;
        return;
    }
    SslPointer ssl = tls_ ? tls_->session(accepted.fd.get()) : nullptr;
    if (tls_ && !ssl) return;
    auto owned = std::make_unique<Connection>(std::move(accepted.fd), std::move(ssl), stats_);
    Connection& connection = *owned;
    connection.host = std::move(accepted.host);
    connection.port = accepted.port;
    connections_.emplace(&connection, std::move(owned));
    if (crowded) return refuse(connection, full("too many connections are open", "--connections"));
    enter(connection, tls_ ? Place::handshake : Place::head, limits_.headTimeout);
    onReady(connection);  // the request has often come with the connection
}

void Front::onReady(Connection& connection) {
    switch (connection.place) {
        case Place::handshake: return onHandshake(connection);
        case Place::head:
        case Place::idle: return onReadable(connection);
        case Place::tail: return sendTail(connection);
        case Place::linger: return linger(connection);
        case Place::handler: return;  // not armed
    }
}

void Front::onHandshake(Connection& connection) {
    const Io io = connection.channel.handshake();
    if (io.status == IoStatus::wantRead || io.status == IoStatus::wantWrite)
        return arm(connection, io.status);
    if (io.status != IoStatus::done) return close(connection);
    connection.place = Place::head;  // within the same deadline
    onReadable(connection);
}

void Front::onReadable(Connection& connection) {
    while (true) {
        const Io io = connection.channel.read(scratch_);
        if (io.status == IoStatus::wantRead || io.status == IoStatus::wantWrite)
            return arm(connection, io.status);
        if (io.status != IoStatus::done) return close(connection);
        connection.in.append(scratch_.data(), io.bytes);
        if (!goesOnReading(connection)) return;
        if (!connection.channel.secure() && io.bytes < scratch_.size())
            return arm(connection, IoStatus::wantRead);
    }
}

/// Looks at what has come. @return false if the connection has left this place
bool Front::goesOnReading(Connection& connection) {
    const HeadVerdict verdict = connection.scan(limits_);
    if (verdict.status != 0) {
        refuse(connection, refusalProblem(verdict));
        return false;
    }
    if (verdict.complete) {
        // Not a limit of the answer: of the time until a thread has taken it.
        enter(connection, Place::handler, limits_.waitTimeout);
        pool_.submit(connection);
        return false;
    }
    if (connection.place == Place::idle) enter(connection, Place::head, limits_.headTimeout);
    return true;
}

/// A connection comes back from its handler.
void Front::onReturned(Connection& connection) {
    if (connection.failed || broken_) return close(connection);
    if (connection.out.empty() && connection.keep) return resume(connection);
    beginTail(connection);
}

/// Sends what the client has not taken yet, then goes on as `keep` says.
void Front::beginTail(Connection& connection) {
    if (connection.out.empty()) return beginLinger(connection);
    enter(connection, Place::tail, limits_.writeGrace);
    connection.guard =
        RateGuard(limits_.writeGrace, limits_.leastRate, NetClock::now(), connection.delivered());
    sendTail(connection);
}

/// Looks for the next request, of which some may have been read already.
void Front::resume(Connection& connection) {
    enter(connection, Place::idle, limits_.idleTimeout);
    if (connection.in.empty()) std::string().swap(connection.in);
    if (!connection.in.empty() && !goesOnReading(connection)) return;
    if (connection.channel.secure()) return onReadable(connection);  // TLS may hold bytes back
    arm(connection, IoStatus::wantRead);
}

void Front::sendTail(Connection& connection) {
    const IoStatus status = connection.out.flush(connection.channel, kTurn);
    if (status == IoStatus::wantRead || status == IoStatus::wantWrite)
        return arm(connection, status);
    if (status != IoStatus::done) return close(connection);
    if (connection.keep) return resume(connection);
    beginLinger(connection);
}

/// Lets the client read its answer: closing with unread bytes would make the kernel reset the
/// connection, and the answer might be lost on the other side.
void Front::beginLinger(Connection& connection) {
    connection.channel.endWriting();
    enter(connection, Place::linger, limits_.lingerTimeout);
    linger(connection);
}

void Front::linger(Connection& connection) {
    while (connection.discarded < limits_.lingerBytes) {
        const Io io = connection.channel.discard(scratch_);
        if (io.status == IoStatus::wantRead) return arm(connection, io.status);
        if (io.status != IoStatus::done) return close(connection);
        connection.discarded += io.bytes;
    }
    // What comes beyond waits in the kernel, which then takes no more: a client or a proxy that is
    // held back so reads its answer, and is not reset while it writes. The deadline closes.
}

/// Answers without a handler, then closes.
void Front::refuse(Connection& connection, const proto::Problem& problem) {
    ++stats_.refused;
    const std::string id = randomRequestId();
    connection.keep = false;
    connection.out.copy(cannedAnswer(problem, id));
    if (refused_) refused_(problem.type.status, id);
    beginTail(connection);
}

void Front::onDeadline(Connection& connection, NetClock::time_point now) {
    if (broken_ && connection.place != Place::handler) return close(connection);
    switch (connection.place) {
        case Place::linger: return close(connection);
        case Place::handshake: ++stats_.timedOut; return close(connection);
        case Place::head:
            ++stats_.timedOut;
            if (connection.in.empty()) return close(connection);
            return refuse(connection, proto::Problem{proto::transportProblemType(408),
                                                     "the head comes too slowly"});
        case Place::idle: return beginLinger(connection);
        case Place::handler:
            connection.deadline = NetClock::time_point::max();
            if (pool_.withdraw(connection))
                refuse(connection, full("too many requests are being answered", ""));
            return;
        case Place::tail:
            if (connection.guard.tooSlow(now, connection.delivered())) {
                ++stats_.timedOut;
                return close(connection);
            }
            connection.deadline = connection.guard.windowEnd();
    }
}

void Front::sweep(NetClock::time_point now) {
    nextSweep_ = now + kTick;
    if (stopping_) sweepAtStop(now);
    if (accepting_ && acceptor_->exhausted()) pollListener(true);
    std::vector<Connection*> due;
    for (const auto& [connection, owned] : connections_)
        if (connection->deadline <= now) due.push_back(connection);
    for (Connection* connection : due) onDeadline(*connection, now);
}

/// Ends accepting; gives clients that say nothing a moment, and answers under way their time-out.
void Front::sweepAtStop(NetClock::time_point now) {
    const bool first = std::exchange(accepting_, false);
    if (first) {
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, acceptor_->fd(), nullptr);
        stopBegan_ = now;
    }
    broken_ = now >= stopBegan_ + limits_.stopTimeout;
    for (const auto& [connection, owned] : connections_) {
        if (first && !isAnswering(connection->place))
            connection->deadline = std::min(connection->deadline, now + limits_.farewell);
        if (!broken_) continue;
        ::shutdown(connection->channel.fd(), SHUT_RDWR);  // wakes a handler that waits
        connection->deadline = now;
    }
}

/// Waits for one event, then for none until the next call: a connection that is in a handler, or
/// was closed, is never in a batch of events.
void Front::arm(Connection& connection, IoStatus wanted) {
    const std::uint32_t events = wanted == IoStatus::wantWrite ? EPOLLOUT : EPOLLIN;
    epoll_event event{events | EPOLLONESHOT, {&connection}};
    const bool known = std::exchange(connection.watched, true);
    if (::epoll_ctl(epoll_.get(), known ? EPOLL_CTL_MOD : EPOLL_CTL_ADD, connection.channel.fd(),
                    &event) != 0)
        close(connection);
}

void Front::enter(Connection& connection, Place place, NetLimits::Time timeout) {
    connection.place = place;
    connection.mark.enter(phaseOf(place));
    const bool last = stopping_ && !isAnswering(place);
    connection.deadline = NetClock::now() + (last ? std::min(timeout, limits_.farewell) : timeout);
}

void Front::close(Connection& connection) { connections_.erase(&connection); }

void Front::takeReturned() {
    eventfd_t ignored = 0;
    ::eventfd_read(wake_.get(), &ignored);
    std::vector<Connection*> returned;
    {
        const std::lock_guard lock(mutex_);
        returned.swap(returned_);
    }
    for (Connection* connection : returned) onReturned(*connection);
}

/// Answers a request and those that follow it closely, then gives the connection back.
void Front::handle(Connection& connection) {
    do {
        ++stats_.requests;
        ++stats_.activeRequests;
        engine_.answer(connection, limits_, stopping_);
        --stats_.activeRequests;
    } while (connection.keep && connection.out.empty() && nextIsHere(connection));
    const std::lock_guard lock(mutex_);
    returned_.push_back(&connection);
    if (returned_.size() == 1) ::eventfd_write(wake_.get(), 1);
}

/// Waits a moment for the next request: to stay is cheaper than to come back.
bool Front::nextIsHere(Connection& connection) {
    const auto until = NetClock::now() + limits_.spin;
    connection.mark.enter(Phase::idle);
    std::array<char, kReadSize> buffer;
    while (!pool_.crowded() && !stopping_) {
        const HeadVerdict verdict = connection.scan(limits_);
        if (verdict.complete) return true;
        if (verdict.status != 0) return false;
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - NetClock::now());
        const bool mayHoldBytes = connection.channel.secure();  // that no poll sees
        if (!mayHoldBytes && !waitFor(connection.channel, IoStatus::wantRead,
                                      std::max(0, static_cast<int>(left.count()))))
            return false;
        const Io io = connection.channel.read(buffer);
        if (io.status == IoStatus::done)
            connection.in.append(buffer.data(), io.bytes);
        else if (io.status != IoStatus::wantRead || left <= 0ms || !mayHoldBytes ||
                 !waitFor(connection.channel, io.status, static_cast<int>(left.count())))
            return false;
    }
    return false;
}

}  // namespace rivage::server
