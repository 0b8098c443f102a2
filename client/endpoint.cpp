#include "client/endpoint.h"

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

}  // namespace

Outcome<Endpoint> parseEndpoint(std::string_view text) {
    if (text.starts_with(kUnix)) {
        const std::string_view path = text.substr(kUnix.size());
        if (path.empty()) return refuse(text, "the path of the socket is missing");
        if (path.size() >= sizeof(sockaddr_un::sun_path))
            return refuse(text, "the path of a Unix socket has at most 107 bytes");
        return Endpoint{std::string(path), 0};
    }
    const bool tls = text.starts_with(kHttps);
    if (!tls && !text.starts_with(kHttp))
        return refuse(text, "expected http://HOST:PORT, https://HOST:PORT or unix:/PATH");
    std::string_view rest = text.substr(tls ? kHttps.size() : kHttp.size());
    if (rest.ends_with('/')) rest.remove_suffix(1);
    if (rest.find('/') != std::string_view::npos)
        return refuse(text, "the address must not have a path");

    Endpoint endpoint{.host = {}, .port = tls ? 443 : 80, .tls = tls};
    const std::size_t colon = rest.rfind(':');
    const std::size_t bracket = rest.rfind(']');  // the end of an IPv6 address
    const bool hasPort =
        colon != std::string_view::npos && (bracket == std::string_view::npos || colon > bracket);
    if (hasPort && !parsePort(rest.substr(colon + 1), endpoint.port))
        return refuse(text, "the port must be a number from 1 to 65535");
    std::string_view host = hasPort ? rest.substr(0, colon) : rest;
    if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
    if (host.empty()) return refuse(text, "the host is missing");
    endpoint.host = host;
    return endpoint;
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
