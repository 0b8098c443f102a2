#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace rivage::client {

/// One connection to a server that may do anything to it.
class RawConnection {
public:
    explicit RawConnection(int socket) : socket_(socket) {}
    ~RawConnection() { close(socket_); }
    RawConnection(const RawConnection&) = delete;
    RawConnection& operator=(const RawConnection&) = delete;

    void send(std::string_view bytes) const {
        while (!bytes.empty()) {
            const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (sent <= 0) return;
            bytes.remove_prefix(static_cast<std::size_t>(sent));
        }
    }
    /// The connection ends as after a crash, not as after an answer.
    void reset() const {
        const linger hard{1, 0};
        setsockopt(socket_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    }
    /// Says nothing until the client gives up.
    void stall() const {
        char byte = 0;
        while (recv(socket_, &byte, 1, 0) > 0) {
        }
    }
    /// Reads one request with its body.
    [[nodiscard]] std::string readRequest() const {
        std::string text;
        std::size_t need = std::string::npos;
        char buffer[4096];
        while (text.size() < need) {
            const ssize_t got = recv(socket_, buffer, sizeof buffer, 0);
            if (got <= 0) break;
            text.append(buffer, static_cast<std::size_t>(got));
            const std::size_t end = text.find("\r\n\r\n");
            if (need == std::string::npos && end != std::string::npos)
                need = end + 4 + bodyLength(text);
        }
        return text;
    }

private:
    static std::size_t bodyLength(const std::string& head) {
        constexpr std::string_view kName = "Content-Length: ";
        const std::size_t at = head.find(kName);
        return at == std::string::npos ? 0 : std::stoul(head.substr(at + kName.size()));
    }
    int socket_;
};

/// A server of bare sockets on a free loopback port, for answers that no HTTP library would give.
/// Each connection is one request; `answer` runs in a thread of its own.
class RawServer {
public:
    using Answer = std::function<void(const std::string& request, const RawConnection&)>;

    explicit RawServer(Answer answer) : answer_(std::move(answer)) {
        listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address);
        socklen_t size = sizeof address;
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
        listen(listener_, 64);
        thread_ = std::thread([this] { run(); });
    }
    ~RawServer() {
        shutdown(listener_, SHUT_RDWR);
        thread_.join();
        for (std::thread& thread : threads_) thread.join();
        close(listener_);
    }
    RawServer(const RawServer&) = delete;
    RawServer& operator=(const RawServer&) = delete;

    [[nodiscard]] int port() const { return port_; }
    [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

private:
    void run() {
        for (int socket = accept(listener_, nullptr, nullptr); socket >= 0;
             socket = accept(listener_, nullptr, nullptr))
            threads_.emplace_back([this, socket] {
                const RawConnection connection(socket);
                const std::string request = connection.readRequest();
                if (!request.empty()) answer_(request, connection);
            });
    }

    Answer answer_;
    int listener_ = -1;
    int port_ = 0;
    std::thread thread_;
    std::vector<std::thread> threads_;
};

}  // namespace rivage::client
