#pragma once

#include <httplib.h>
#include <openssl/evp.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace rivage::server {

using Sha256 = std::array<unsigned char, 32>;

/// Reads the sha-256 of a Content-Digest or Repr-Digest field (RFC 9530).
/// @param field  its value; several lines are joined with commas
/// @return the digest; nothing if there is none of this algorithm
/// @errors malformedRequest if it is no dictionary of byte sequences, or the digest has other than
///         32 bytes
core::Result<std::optional<Sha256>> parseDigestField(std::string_view field);

/// The sha-256 that a header of a request announces. @errors as `parseDigestField`; the field is
/// "/headers/" and the name in lower case
core::Result<std::optional<Sha256>> digestHeader(const httplib::Request& request, const char* name);

/// Compares bytes that come piece by piece with the digest that was announced for them.
class DigestCheck {
public:
    /// @param expected  nothing: whatever comes is right, and costs nothing
    explicit DigestCheck(std::optional<Sha256> expected);
    void update(const char* data, std::size_t size);
    /// Once, after the last byte.
    [[nodiscard]] bool matches();

private:
    std::optional<Sha256> expected_;
    std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace rivage::server
