#pragma once

#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace rivage::client {

/// A SHA-256 that grows with what comes.
class Sha256 {
public:
    Sha256();
    void restart();
    void update(std::string_view bytes);
    /// As `Repr-Digest` writes it, "sha-256=:BASE64:"; more may come afterwards.
    [[nodiscard]] std::string field() const;

private:
    std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

/// Whether a digest field of HTTP (RFC 9530) names another SHA-256 than `field`. One that names none
/// contradicts nothing.
[[nodiscard]] bool contradicts(std::string_view digests, std::string_view field);

}  // namespace rivage::client
