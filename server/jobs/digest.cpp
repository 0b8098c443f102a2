#include "server/jobs/digest.h"

#include <openssl/evp.h>

#include <array>
#include <stdexcept>

namespace rivage::server {

Digest sha256(std::span<const std::byte> bytes) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> hash{};
    unsigned int length = 0;
    if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), &length, EVP_sha256(), nullptr) != 1)
        throw std::runtime_error("sha-256 failed");

    Digest digest;
    constexpr char kHex[] = "0123456789abcdef";
    for (unsigned int i = 0; i < length; ++i) {
        digest.hex += kHex[hash[i] >> 4];
        digest.hex += kHex[hash[i] & 15];
    }
    std::array<unsigned char, 2 * EVP_MAX_MD_SIZE> base64{};
    const int written = EVP_EncodeBlock(base64.data(), hash.data(), static_cast<int>(length));
    digest.base64.assign(base64.begin(), base64.begin() + written);
    return digest;
}

}  // namespace rivage::server
