#include "server/net/connection_stream.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace rivage::server {
namespace {

/// Smaller reads fill the buffer, so that the parser does not ask the kernel byte by byte.
constexpr std::size_t kReadAhead = 16 << 10;
constexpr std::uint64_t kMaxBodyToSkip = 64 << 10;

int millisecondsUntil(NetClock::time_point until) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - NetClock::now());
    return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 60000));
}

}  // namespace

ConnectionStream::ConnectionStream(Connection& connection, const NetLimits& limits,
                                   const std::atomic<bool>& stopping)
    : connection_(connection), limits_(limits), stopping_(stopping) {}

ConnectionStream::~ConnectionStream() {
    connection_.in.erase(0, used_);
    connection_.scanner = {};
}

bool ConnectionStream::mayKeep() const {
    return !stopping_ && connection_.requests < limits_.requestsPerConnection;
}

void ConnectionStream::beginStreaming() {
    streaming_ = true;
    connection_.mark.enter(Phase::stream);
}

void ConnectionStream::get_remote_ip_and_port(std::string& ip, int& port) const {
    ip = connection_.host;
    port = connection_.port;
}

/// A client that has only ended its sending still gets an answer whose end is known; a stream
/// would go on for nobody, so there it counts as gone.
bool ConnectionStream::is_peer_alive() const {
    if (connection_.failed) return false;
    return streaming_ ? !clientLeft() : !isBroken(connection_.channel.fd());
}

const char* ConnectionStream::buffered_data(std::size_t& size) const {
    size = connection_.in.size() - used_;
    return size > 0 ? connection_.in.data() + used_ : nullptr;
}

ssize_t ConnectionStream::read(char* into, std::size_t size) {
    std::string& in = connection_.in;
    if (used_ == in.size()) {
        received_ += in.size();
        in.clear();
        used_ = 0;
        std::array<char, kReadAhead> ahead;
        const bool direct = size >= ahead.size();
        const Io io = receive(direct ? std::span(into, size) : std::span<char>(ahead));
        if (io.status != IoStatus::done) return io.status == IoStatus::ended ? 0 : -1;
        if (direct) {
            received_ += io.bytes;
            return static_cast<ssize_t>(io.bytes);
        }
        in.assign(ahead.data(), io.bytes);
    }
    const std::size_t taken = std::min(size, in.size() - used_);
    std::memcpy(into, in.data() + used_, taken);
    used_ += taken;
    return static_cast<ssize_t>(taken);
}

/// Reads from the socket; waits for a body that comes at the least rate.
Io ConnectionStream::receive(std::span<char> into) {
    while (true) {
        const Io io = connection_.channel.read(into);
        if (io.status == IoStatus::ended) return io;
        if (io.status == IoStatus::done && received_ + io.bytes <= limits_.bodyBytes) return io;
        if (io.status == IoStatus::done || io.status == IoStatus::failed ||
            !waitForBody(io.status)) {
            error_ = bodyTimedOut_ ? httplib::Error::Timeout : httplib::Error::Read;
            return {IoStatus::failed, 0};
        }
    }
}

bool ConnectionStream::waitForBody(IoStatus wanted) {
    const auto received = static_cast<std::int64_t>(received_);
    const auto now = NetClock::now();
    if (!bodyGuard_) {
        bodyGuard_.emplace(limits_.bodyGrace, limits_.leastRate, now, received);
        bodyEnd_ = now + limits_.bodyTimeout;
    }
    bodyTimedOut_ = now >= bodyEnd_ || bodyGuard_->tooSlow(now, received);
    if (bodyTimedOut_) return false;
    connection_.mark.enter(Phase::body);
    waitFor(connection_.channel, wanted,
            millisecondsUntil(std::min(bodyEnd_, bodyGuard_->windowEnd())));
    connection_.mark.enter(Phase::handler);
    return true;
}

bool ConnectionStream::tookBody(std::uint64_t length) const {
    return received_ + used_ >= connection_.scanner.size() + length;
}

bool ConnectionStream::hasBody(std::uint64_t length) {
    const std::uint64_t end = connection_.scanner.size() + length;
    if (length > kMaxBodyToSkip) return false;
    std::array<char, kReadAhead> ahead;
    while (received_ + connection_.in.size() < end) {
        const Io io = connection_.channel.read(ahead);
        if (io.status != IoStatus::done) return false;
        connection_.in.append(ahead.data(), io.bytes);
    }
    return true;
}

ssize_t ConnectionStream::write(const char* bytes, std::size_t size) {
    std::string_view rest(bytes, size);
    std::optional<RateGuard> guard;
    while (true) {
        const IoStatus status = sendSome(rest);
        if (rest.empty() || leave(rest)) return static_cast<ssize_t>(size);
        if (!waitForClient(status, guard)) return -1;
    }
}

/// Sends what waits, then of `rest` what the socket takes.
IoStatus ConnectionStream::sendSome(std::string_view& rest) {
    Output& out = connection_.out;
    IoStatus status = out.flush(connection_.channel);
    while (status == IoStatus::done && !rest.empty()) {
        const Io io = out.sendNow(connection_.channel, rest);
        status = io.status;
        rest.remove_prefix(io.bytes);
    }
    connection_.failed = status == IoStatus::failed || status == IoStatus::ended;
    return status;
}

/// Leaves the end of an answer to the front, which sends it when the client takes it.
bool ConnectionStream::leave(std::string_view rest) {
    Output& out = connection_.out;
    if (connection_.failed || streaming_) return false;
    if (lent_.holds(rest)) {
        out.lend(lent_.owner, rest);
        return true;
    }
    if (rest.size() + out.copiedBytes() > limits_.copiedBytes) return false;
    out.copy(rest);
    return true;
}

/// Waits until the client takes more. @return false if it is broken, or takes it too slowly
bool ConnectionStream::waitForClient(IoStatus wanted, std::optional<RateGuard>& guard) {
    if (connection_.failed) return false;
    const auto now = NetClock::now();
    if (!guard) guard.emplace(limits_.writeGrace, limits_.leastRate, now, connection_.delivered());
    connection_.failed = guard->tooSlow(now, connection_.delivered());
    if (connection_.failed) return false;
    connection_.mark.enter(Phase::stream);
    waitFor(connection_.channel, wanted, millisecondsUntil(guard->windowEnd()));
    return true;
}

}  // namespace rivage::server
