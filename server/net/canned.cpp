#include "server/net/canned.h"

#include <openssl/rand.h>

#include <array>

namespace rivage::server {

std::string randomRequestId() {
    std::array<unsigned char, 12> random{};
    ::RAND_bytes(random.data(), static_cast<int>(random.size()));
    constexpr char kHex[] = "0123456789abcdef";
    std::string id;
    for (const unsigned char byte : random) {
        id += kHex[byte >> 4];
        id += kHex[byte & 15];
    }
    return id;
}

std::string cannedAnswer(const proto::Problem& problem, const std::string& requestId) {
    const std::string body = proto::writeJson(proto::toJson(problem)) + "\n";
    std::string answer = "HTTP/1.1 " + std::to_string(problem.type.status) + " " +
                         std::string(problem.type.title) + "\r\n";
    if (problem.type.status == 503) answer += "Retry-After: 1\r\n";
    answer += "Content-Type: " + std::string(proto::kProblemMediaType) +
              "\r\nContent-Length: " + std::to_string(body.size()) +
              "\r\nX-Request-ID: " + requestId +
              "\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n";
    return answer + body;
}

}  // namespace rivage::server
