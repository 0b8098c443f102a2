#pragma once

#include <openssl/ssl.h>

#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"

namespace rivage::server {

struct SslDelete {
    void operator()(SSL* ssl) const { ::SSL_free(ssl); }
    void operator()(SSL_CTX* context) const { ::SSL_CTX_free(context); }
};
using SslPointer = std::unique_ptr<SSL, SslDelete>;

/// Certificate and key of the server: TLS 1.2 and 1.3, no renegotiation.
class TlsContext {
public:
    /// @param certificate  PEM file: the certificate, then those that lead to its root
    /// @param key          PEM file: the private key
    /// @errors invalidOption, with the flag whose file is at fault
    static core::Result<std::unique_ptr<TlsContext>> load(std::string certificate, std::string key);

    /// Reads the files again, for new connections; keeps the old certificate if that fails.
    /// @errors as `load`
    core::Result<void> reload();

    /// The server side of a connection; null if memory is short.
    [[nodiscard]] SslPointer session(int socket) const;

private:
    using Context = std::unique_ptr<SSL_CTX, SslDelete>;
    TlsContext(std::string certificate, std::string key)
        : certificate_(std::move(certificate)), key_(std::move(key)) {}
    [[nodiscard]] core::Result<Context> read() const;

    const std::string certificate_;
    const std::string key_;
    mutable std::mutex mutex_;
    Context context_;
};

}  // namespace rivage::server
