#include "server/http/digest_fields.h"

#include <algorithm>
#include <cctype>

#include "server/http/exchange.h"
#include "server/http/text.h"

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

bool isKey(std::string_view key) {
    return !key.empty() && (std::islower(static_cast<unsigned char>(key[0])) || key[0] == '*') &&
           std::all_of(key.begin(), key.end(), [](unsigned char c) {
               return std::islower(c) || std::isdigit(c) || c == '_' || c == '-' || c == '.' ||
                      c == '*';
           });
}

/// `:base64:`, maybe with parameters behind it -> the text between the colons.
std::optional<std::string_view> byteSequence(std::string_view value) {
    if (!value.starts_with(':')) return std::nullopt;
    const std::size_t end = value.find(':', 1);
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view rest = trimmed(value.substr(end + 1));
    if (!rest.empty() && !rest.starts_with(';')) return std::nullopt;
    const std::string_view base64 = value.substr(1, end - 1);
    const bool valid =
        base64.size() % 4 == 0 && std::all_of(base64.begin(), base64.end(), [](unsigned char c) {
            return std::isalnum(c) || c == '+' || c == '/' || c == '=';
        });
    return valid ? std::optional(base64) : std::nullopt;
}

/// 32 bytes are 43 digits and one '='.
std::optional<Sha256> decodeSha256(std::string_view base64) {
    if (base64.size() != 44 || base64.find('=') != 43) return std::nullopt;
    std::array<unsigned char, 33> bytes{};
    const auto* text = reinterpret_cast<const unsigned char*>(base64.data());
    if (::EVP_DecodeBlock(bytes.data(), text, 44) != 33) return std::nullopt;
    Sha256 digest{};
    std::copy_n(bytes.begin(), digest.size(), digest.begin());
    return digest;
}

}  // namespace

core::Result<std::optional<Sha256>> parseDigestField(std::string_view field) {
    const core::Error malformed{ErrorCode::malformedRequest,
                                "a digest is written as sha-256=:BASE64:"};
    std::optional<Sha256> digest;
    while (true) {
        const std::size_t comma = std::min(field.find(','), field.size());
        const std::string_view member = trimmed(field.substr(0, comma));
        const std::size_t equals = std::min(member.find('='), member.size());
        const std::string_view key = member.substr(0, equals);
        const auto value = byteSequence(member.substr(std::min(equals + 1, member.size())));
        if (!isKey(key) || !value) return fail(malformed);
        if (key == "sha-256" && !(digest = decodeSha256(*value))) return fail(malformed);
        if (comma == field.size()) return digest;
        field.remove_prefix(comma + 1);
    }
}

core::Result<std::optional<Sha256>> digestHeader(const httplib::Request& request,
                                                 const char* name) {
    if (!request.has_header(name)) return std::optional<Sha256>();
    auto digest = parseDigestField(listField(request, name));
    if (digest) return digest;
    core::Error error = digest.error();
    error.field = "/headers/" + lowerCase(name);
    return fail(std::move(error));
}

DigestCheck::DigestCheck(std::optional<Sha256> expected)
    : expected_(expected), context_(expected ? ::EVP_MD_CTX_new() : nullptr, ::EVP_MD_CTX_free) {
    if (context_) ::EVP_DigestInit_ex(context_.get(), ::EVP_sha256(), nullptr);
}

void DigestCheck::update(const char* data, std::size_t size) {
    if (context_) ::EVP_DigestUpdate(context_.get(), data, size);
}

bool DigestCheck::matches() {
    if (!expected_) return true;
    Sha256 actual{};
    return context_ && ::EVP_DigestFinal_ex(context_.get(), actual.data(), nullptr) == 1 &&
           actual == *expected_;
}

}  // namespace rivage::server
