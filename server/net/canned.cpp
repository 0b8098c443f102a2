#include "server/net/canned.h"

#include <openssl/rand.h>

#include <stdexcept>
#include <vector>

namespace rivage::server {

std::string randomHex(std::size_t bytes) {
    std::vector<unsigned char> random(bytes);
    if (::RAND_bytes(random.data(), static_cast<int>(bytes)) != 1)
        throw std::runtime_error("the system has no random numbers");
    constexpr char kHex[] = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : random) {
        text += kHex[byte >> 4];
        text += kHex[byte & 15];
    }
    return text;
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
