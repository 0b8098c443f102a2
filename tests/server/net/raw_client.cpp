#include "tests/server/net/raw_client.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace rivage::test {
namespace {

using Clock = std::chrono::steady_clock;

bool connectTo(int fd, const server::Address& address) {
    if (address.isUnix()) {
        sockaddr_un name{};
        name.sun_family = AF_UNIX;
        address.path.copy(name.sun_path, sizeof name.sun_path - 1);
        return ::connect(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0;
    }
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(static_cast<std::uint16_t>(address.port));
    ::inet_pton(AF_INET, address.host.c_str(), &name.sin_addr);
    return ::connect(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0;
}

}  // namespace

RawClient::RawClient(const server::Address& address, int receiveBuffer)
    : fd_(::socket(address.isUnix() ? AF_UNIX : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (receiveBuffer > 0)
        ::setsockopt(fd(), SOL_SOCKET, SO_RCVBUF, &receiveBuffer, sizeof receiveBuffer);
    connected_ = connectTo(fd(), address);
}

bool RawClient::send(const std::string& bytes) const {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
        const ssize_t n = ::send(fd(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) return false;
        sent += static_cast<std::size_t>(n);
    }
    return true;
}

void RawClient::endSending() const { ::shutdown(fd(), SHUT_WR); }

bool RawClient::receive(Clock::time_point until) {
    if (ended_) return false;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd waiting{fd(), POLLIN, 0};
    if (left <= 0 || ::poll(&waiting, 1, static_cast<int>(left)) <= 0) return false;
    char buffer[65536];
    const ssize_t n = ::recv(fd(), buffer, sizeof buffer, 0);
    ended_ = n <= 0;
    if (n > 0) received_.append(buffer, static_cast<std::size_t>(n));
    return n > 0;
}

std::string RawClient::readUntil(const std::string& end, std::chrono::milliseconds time) {
    const auto until = Clock::now() + time;
    std::size_t at = 0;
    while ((at = received_.find(end)) == std::string::npos)
        if (!receive(until)) return std::exchange(received_, {});
    std::string taken = received_.substr(0, at + end.size());
    received_.erase(0, taken.size());
    return taken;
}

std::string RawClient::readAnswer(std::chrono::milliseconds time) {
    const auto until = Clock::now() + time;
    std::string answer = readUntil("\r\n\r\n", time);
    const std::size_t field = answer.find("Content-Length: ");
    const std::size_t size =
        field == std::string::npos ? 0 : std::strtoul(answer.c_str() + field + 16, nullptr, 10);
    while (received_.size() < size && receive(until)) {
    }
    const std::size_t taken = std::min(size, received_.size());
    answer += received_.substr(0, taken);
    received_.erase(0, taken);
    return answer;
}

std::string RawClient::readAll(std::chrono::milliseconds time) {
    const auto until = Clock::now() + time;
    while (receive(until)) {
    }
    return std::exchange(received_, {});
}

bool RawClient::closedWithin(std::chrono::milliseconds time) {
    return readAll(time).empty() && ended_;
}

std::string get(const std::string& path, const std::string& headers) {
    return "GET " + path + " HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n";
}

int statusOf(const std::string& answer) {
    return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0;
}

}  // namespace rivage::test
