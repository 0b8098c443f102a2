#include "server/jobs/digest.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/sha.h>

#include <array>
#include <charconv>
#include <stdexcept>

namespace rivage::server {
namespace {

using Hash = std::array<unsigned char, SHA256_DIGEST_LENGTH>;

Digest written(const Hash& hash) {
    Digest digest;
    constexpr char kHex[] = "0123456789abcdef";
    for (const unsigned char byte : hash) {
        digest.hex += kHex[byte >> 4];
        digest.hex += kHex[byte & 15];
    }
    std::array<unsigned char, 2 * SHA256_DIGEST_LENGTH> base64{};
    const int length = EVP_EncodeBlock(base64.data(), hash.data(), static_cast<int>(hash.size()));
    digest.base64.assign(base64.begin(), base64.begin() + length);
    return digest;
}

}  // namespace

Digest sha256(std::span<const std::byte> bytes) {
    Hash hash{};
    if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), nullptr, EVP_sha256(), nullptr) != 1)
        throw std::runtime_error("sha-256 failed");
    return written(hash);
}

Digest digestOf(const std::string& hex) {
    Hash hash{};
    if (hex.size() != 2 * hash.size()) return {};
    for (std::size_t i = 0; i < hash.size(); ++i) {
        const char* const begin = hex.data() + 2 * i;
        if (std::from_chars(begin, begin + 2, hash[i], 16).ptr != begin + 2) return {};
    }
    return written(hash);
}

}  // namespace rivage::server
