#include "server/net/address.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// Whether a process accepts connections at this path.
bool somebodyListens(const std::string& path) {
    const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (socket < 0) return true;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    const int connected =
        ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    const bool refused = connected != 0 && (errno == ECONNREFUSED || errno == ENOENT);
    ::close(socket);
    return !refused;
}

}  // namespace

std::string Address::url() const {
    if (isUnix()) return "unix:" + path;
    const bool v6 = host.find(':') != std::string::npos;
    return "http://" + (v6 ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

core::Result<Address> parseAddress(const std::string& text) {
    Address address;
    if (text.starts_with("unix:")) {
        address.path = text.substr(5);
        if (address.path.empty() || address.path.size() >= sizeof(sockaddr_un::sun_path) ||
            address.path.front() == '\0')
            return fail(ErrorCode::invalidOption,
                        "the path of a Unix socket has 1 to " +
                            std::to_string(sizeof(sockaddr_un::sun_path) - 1) + " bytes");
        return address;
    }
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos)
        return fail(ErrorCode::invalidOption,
                    "\"" + text + "\" is not host:port, [ipv6]:port or unix:/path");
    const std::string_view port = std::string_view(text).substr(colon + 1);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    if (error != std::errc() || end != port.data() + port.size() || address.port < 0 ||
        address.port > 65535)
        return fail(ErrorCode::invalidOption, "the port of \"" + text + "\" is not 0 to 65535");
    address.host = text.substr(0, colon);
    if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']')
        address.host = address.host.substr(1, address.host.size() - 2);
    if (address.host.empty()) address.host = "0.0.0.0";
    return address;
}

core::Result<void> clearStaleSocket(const std::string& path) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) return {};
    if (!S_ISSOCK(status.st_mode))
        return fail(ErrorCode::invalidOption, path + " exists and is not a socket");
    if (somebodyListens(path)) return fail(ErrorCode::busy, "another server listens at " + path);
    ::unlink(path.c_str());
    return {};
}

void removeSocketFile(const Address& address) {
    if (address.isUnix()) ::unlink(address.path.c_str());
}

}  // namespace rivage::server
