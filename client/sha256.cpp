#include "client/sha256.h"

#include <openssl/evp.h>

#include <array>

namespace rivage::client {
namespace {

constexpr std::string_view kName = "sha-256=:";

}  // namespace

Sha256::Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) { restart(); }

void Sha256::restart() { EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr); }

void Sha256::update(std::string_view bytes) {
    EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size());
}

std::string Sha256::field() const {
    const Sha256 copy;
    EVP_MD_CTX_copy_ex(copy.context_.get(), context_.get());
    std::array<unsigned char, 32> digest{};
    EVP_DigestFinal_ex(copy.context_.get(), digest.data(), nullptr);
    std::array<unsigned char, 45> base64{};  // 4 * 11 and the end of the text
    EVP_EncodeBlock(base64.data(), digest.data(), static_cast<int>(digest.size()));
    return std::string(kName) + reinterpret_cast<const char*>(base64.data()) + ":";
}

bool contradicts(std::string_view digests, std::string_view field) {
    const std::size_t begin = digests.find(kName);
    return begin != std::string_view::npos && digests.substr(begin, field.size()) != field;
}

}  // namespace rivage::client
