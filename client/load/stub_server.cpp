#include "client/load/stub_server.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

namespace rivage::client::load {
namespace {

constexpr int kBacklog = 4096;
constexpr std::size_t kMaxHead = 64 << 10;
constexpr std::chrono::milliseconds kFullPause{10};

void watch(int epoll, int fd) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.fd = fd;
    epoll_ctl(epoll, EPOLL_CTL_ADD, fd, &event);
}

/// Listens on loopback. @return the port; 0 if that failed
int listenOn(int fd, int port) {
    const int yes = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    auto* raw = reinterpret_cast<sockaddr*>(&address);
    socklen_t size = sizeof address;
    if (bind(fd, raw, size) != 0 || listen(fd, kBacklog) != 0 || getsockname(fd, raw, &size) != 0)
        return 0;
    return ntohs(address.sin_port);
}

}  // namespace

StubServer::StubServer(const StubSettings& settings)
    : settings_(settings),
      answer_("HTTP/1.1 200 OK\r\nContent-Type: text/plain\r\nContent-Length: " +
              std::to_string(settings.bodySize) + "\r\n\r\n" + std::string(settings.bodySize, 'x')),
      listener_(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      end_(eventfd(0, EFD_CLOEXEC)),
      port_(listenOn(listener_, settings.port)) {
    if (epoll_ < 0 || end_ < 0) port_ = 0;
    if (port_ == 0) return;
    watch(epoll_, listener_);
    watch(epoll_, end_);
    thread_ = std::thread([this] { serve(); });
}

StubServer::~StubServer() {
    const std::uint64_t one = 1;
    if (thread_.joinable() && write(end_, &one, sizeof one) > 0) thread_.join();
    for (const auto& [client, head] : pending_) close(client);
    for (const int fd : {listener_, epoll_, end_})
        if (fd >= 0) close(fd);
}

void StubServer::serve() {
    std::array<epoll_event, 256> events{};
    for (;;) {
        const int count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), -1);
        for (int i = 0; i < count; ++i) {
            const int fd = events[static_cast<std::size_t>(i)].data.fd;
            if (fd == end_) return;
            if (fd == listener_) {
                admit();
                continue;
            }
            standStill();
            answer(fd);
        }
    }
}

void StubServer::admit() {
    for (;;) {
        const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (client < 0) {
            // The client stays in line, and the loop would ask for it again at once.
            if (errno == EMFILE || errno == ENFILE) std::this_thread::sleep_for(kFullPause);
            return;
        }
        const int yes = 1;
        setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        pending_.try_emplace(client);
        watch(epoll_, client);
    }
}

/// The scripted stall, once: nothing is answered and nothing is read meanwhile.
void StubServer::standStill() {
    const auto now = std::chrono::steady_clock::now();
    if (first_ == std::chrono::steady_clock::time_point{}) first_ = now;
    if (stalled_ || settings_.stallFor.count() <= 0 || now - first_ < settings_.stallAt) return;
    stalled_ = true;
    std::this_thread::sleep_for(settings_.stallFor);
}

void StubServer::work() const {
    if (settings_.work.count() == 0) return;
    const auto end = std::chrono::steady_clock::now() + settings_.work;
    while (std::chrono::steady_clock::now() < end) {
    }
}

void StubServer::answer(int client) {
    std::array<char, 16384> buffer{};
    const ssize_t received = recv(client, buffer.data(), buffer.size(), 0);
    std::string& head = pending_[client];
    bool open = received > 0 && head.size() < kMaxHead;
    std::string_view rest(buffer.data(), open ? static_cast<std::size_t>(received) : 0);
    std::string joined;
    if (!head.empty()) {
        joined = std::move(head);
        joined.append(rest);
        rest = joined;
    }
    for (std::size_t end = rest.find("\r\n\r\n"); open && end != std::string_view::npos;
         end = rest.find("\r\n\r\n")) {
        rest.remove_prefix(end + 4);
        work();
        const ssize_t sent = send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL);
        open = sent == static_cast<ssize_t>(answer_.size());
        ++answered_;
    }
    if (open) {
        head = rest;
        return;
    }
    close(client);
    pending_.erase(client);
}

}  // namespace rivage::client::load
