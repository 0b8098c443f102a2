#pragma once

#include <httplib.h>

#include <atomic>
#include <optional>
#include <string>

#include "server/net/connection.h"

namespace rivage::server {

/// A connection as cpp-httplib sees it while one request is answered. Reads and writes wait with
/// the limits of slow clients; the end of an answer that the client does not take at once is left
/// in the connection's output.
class ConnectionStream final : public httplib::Stream {
public:
    /// @param stopping  whether answers shall be the last of their connection
    ConnectionStream(Connection& connection, const NetLimits& limits,
                     const std::atomic<bool>& stopping);
    /// Takes what was read of this request off the connection's input.
    ~ConnectionStream() override;

    // What handlers ask and say, by way of server/net/answer.h.
    [[nodiscard]] bool clientLeft() const { return peerLeft(connection_.channel.fd()); }
    [[nodiscard]] bool bodyTimedOut() const { return bodyTimedOut_; }
    void lend(Lent lent) { lent_ = std::move(lent); }
    /// The answer has no known end: what is written leaves at once, or waits for the client.
    void beginStreaming();
    /// Whether a body of this length has been read to its end.
    [[nodiscard]] bool tookBody(std::uint64_t length) const;
    /// Whether a body of this length, of which nothing was read, has come and is small.
    bool hasBody(std::uint64_t length);

    [[nodiscard]] bool mayKeep() const;
    void setKeep(bool keep) { keep_ = keep; }
    [[nodiscard]] bool keep() const { return keep_; }

    bool is_readable() const override { return used_ < connection_.in.size(); }
    bool wait_readable() const override { return true; }  // `read` waits
    bool wait_writable() const override { return !connection_.failed; }
    bool is_peer_alive() const override;
    ssize_t read(char* into, std::size_t size) override;
    ssize_t write(const char* bytes, std::size_t size) override;
    void get_remote_ip_and_port(std::string& ip, int& port) const override;
    void get_local_ip_and_port(std::string&, int&) const override {}
    socket_t socket() const override { return connection_.channel.fd(); }
    time_t duration() const override { return 0; }
    const char* buffered_data(std::size_t& size) const override;
    void consume_buffered(std::size_t size) override { used_ += size; }

private:
    Io receive(std::span<char> into);
    bool waitForBody(IoStatus wanted);
    IoStatus sendSome(std::string_view& rest);
    bool leave(std::string_view rest);
    bool waitForClient(IoStatus wanted, std::optional<RateGuard>& guard);

    Connection& connection_;
    const NetLimits& limits_;
    const std::atomic<bool>& stopping_;
    std::size_t used_ = 0;        ///< bytes of `connection_.in`
    std::uint64_t received_ = 0;  ///< bytes that are no longer, or never were, in `connection_.in`
    std::optional<RateGuard> bodyGuard_;
    NetClock::time_point bodyEnd_ = {};
    Lent lent_;
    bool streaming_ = false;
    bool bodyTimedOut_ = false;
    bool keep_ = false;
};

}  // namespace rivage::server
