#pragma once

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <string>
#include <string_view>
#include <thread>

namespace rivage::client::load {

/// One connection of a `ScriptedServer`.
class ScriptedConnection {
public:
    explicit ScriptedConnection(int fd) : fd_(fd) {}
    ~ScriptedConnection() { close(fd_); }
    ScriptedConnection(const ScriptedConnection&) = delete;
    ScriptedConnection& operator=(const ScriptedConnection&) = delete;

    /// Reads the head of a request; empty if the client has left.
    std::string readHead() const {
        std::string head;
        char byte = 0;
        while (!head.ends_with("\r\n\r\n") && recv(fd_, &byte, 1, 0) == 1) head += byte;
        return head.ends_with("\r\n\r\n") ? head : "";
    }
    void write(std::string_view text) const {
        (void)!send(fd_, text.data(), text.size(), MSG_NOSIGNAL);
    }
    /// The connection ends with a reset, not in good order.
    void reset() const {
        const linger now{1, 0};
        setsockopt(fd_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    }

private:
    int fd_;
};

/// A server that treats its connections, one after the other, as the test tells it to.
class ScriptedServer {
public:
    explicit ScriptedServer(std::function<void(const ScriptedConnection&)> script)
        : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
        listen(listener_, 128);
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
        port_ = ntohs(address.sin_port);
        thread_ = std::thread([this, script = std::move(script)] {
            for (int fd = accept(listener_, nullptr, nullptr); fd >= 0;
                 fd = accept(listener_, nullptr, nullptr))
                script(ScriptedConnection(fd));
        });
    }
    ~ScriptedServer() {
        shutdown(listener_, SHUT_RDWR);
        thread_.join();
        close(listener_);
    }
    ScriptedServer(const ScriptedServer&) = delete;
    ScriptedServer& operator=(const ScriptedServer&) = delete;
    [[nodiscard]] std::string url() const { return "http://127.0.0.1:" + std::to_string(port_); }

private:
    int listener_;
    int port_ = 0;
    std::thread thread_;
};

}  // namespace rivage::client::load
