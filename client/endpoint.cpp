#include "client/endpoint.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/un.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>

namespace rivage::client {
namespace {

constexpr std::string_view kHttp = "http://";
constexpr std::string_view kHttps = "https://";
constexpr std::string_view kUnix = "unix:";

bool parsePort(std::string_view text, int& port) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    return error == std::errc() && end == text.data() + text.size() && port > 0 && port < 65536;
}

tl::unexpected<Failure> refuse(std::string_view text, const std::string& why) {
    return fail(ExitCode::usage, "This is no address of a server",
                proto::inQuotes(text) + ": " + why);
}

bool isV6(std::string_view host) {
    in6_addr unused{};
    const std::string address(host.substr(0, host.find('%')));  // without the zone
    return inet_pton(AF_INET6, address.c_str(), &unused) == 1;
}

/// Takes "HOST", "HOST:PORT", "[ADDRESS]" and "[ADDRESS]:PORT" apart.
/// @return  what is wrong; empty: nothing
std::string takeHost(std::string_view rest, Endpoint& endpoint) {
    const bool bracket = rest.starts_with('[');
    const std::size_t end = bracket ? rest.find(']') : std::min(rest.find(':'), rest.size());
    if (end == std::string_view::npos) return "the ']' of the IPv6 address is missing";
    const std::string_view host = bracket ? rest.substr(1, end - 1) : rest.substr(0, end);
    const std::string_view port = rest.substr(bracket ? end + 1 : end);
    if (bracket && !isV6(host)) return "between '[' and ']' there is no IPv6 address";
    if (!bracket && isV6(rest)) return "an IPv6 address stands in brackets";
    if (host.empty()) return "the host is missing";
    const bool plain = std::all_of(host.begin(), host.end(), [](char c) {
        return c > 0x20 && c != 0x7f && std::string_view("[]\\?#<>\"").find(c) == std::string::npos;
    });
    if (!plain) return "the host has characters that no host has";
    if (!port.empty() && (port.front() != ':' || !parsePort(port.substr(1), endpoint.port)))
        return "the port must be a number from 1 to 65535";
    endpoint.host = host;
    return {};
}

}  // namespace

Outcome<Endpoint> parseEndpoint(std::string_view text) {
    if (text.starts_with(kUnix)) {
        const std::string_view path = text.substr(kUnix.size());
        if (path.empty()) return refuse(text, "the path of the socket is missing");
        if (path.size() >= sizeof(sockaddr_un::sun_path))
            return refuse(text, "the path of a Unix socket has at most 107 bytes");
        return Endpoint{std::string(path), 0};
    }
    // Before any words that show the text: what stands before '@' may be a password.
    if (text.find('@') != std::string_view::npos)
        return fail(ExitCode::usage, "This is no address of a server",
                    "it must not have a user or a password before '@'; keys are for "
                    "--api-key-file or RIVAGE_API_KEY");
    const bool tls = text.starts_with(kHttps);
    if (!tls && !text.starts_with(kHttp))
        return refuse(text, "expected http://HOST:PORT, https://HOST:PORT or unix:/PATH");
    std::string_view rest = text.substr(tls ? kHttps.size() : kHttp.size());
    if (rest.ends_with('/')) rest.remove_suffix(1);
    if (rest.find('/') != std::string_view::npos)
        return refuse(text, "the address must not have a path");

    Endpoint endpoint{.host = {}, .port = tls ? 443 : 80, .tls = tls};
    if (const std::string wrong = takeHost(rest, endpoint); !wrong.empty())
        return refuse(text, wrong);
    return endpoint;
}

bool isLoopback(const Endpoint& endpoint) {
    const std::string& host = endpoint.host;
    in_addr v4{};
    in6_addr v6{};
    if (endpoint.isUnix() || host == "localhost" || host.ends_with(".localhost")) return true;
    if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return ntohl(v4.s_addr) >> 24 == 127;
    if (inet_pton(AF_INET6, host.c_str(), &v6) != 1) return false;
    if (IN6_IS_ADDR_V4MAPPED(&v6)) return v6.s6_addr[12] == 127;
    return IN6_IS_ADDR_LOOPBACK(&v6);
}

std::string toText(const Endpoint& endpoint) {
    if (endpoint.isUnix()) return std::string(kUnix) + endpoint.host;
    const bool v6 = endpoint.host.find(':') != std::string::npos;
    return std::string(endpoint.tls ? kHttps : kHttp) +
           (v6 ? "[" + endpoint.host + "]" : endpoint.host) + ":" + std::to_string(endpoint.port);
}

bool isApiKey(std::string_view text) {
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

Outcome<std::string> readApiKey(const std::string& path) {
    std::ifstream file(path);
    std::string key;
    std::getline(file, key);
    while (key.ends_with('\r') || key.ends_with(' ')) key.pop_back();
    if (!file && !file.eof()) return fail(ExitCode::usage, "The API key cannot be read", path);
    if (!isApiKey(key))
        return fail(ExitCode::usage, "This file holds no API key",
                    path + ": its first line has to be the key");
    return key;
}

Outcome<std::string> apiKeyOf(const std::string& file) {
    if (!file.empty()) return readApiKey(file);
    const char* key = std::getenv("RIVAGE_API_KEY");
    if (key == nullptr || *key == '\0') return std::string();
    if (!isApiKey(key)) return fail(ExitCode::usage, "RIVAGE_API_KEY holds no API key");
    return std::string(key);
}

}  // namespace rivage::client
