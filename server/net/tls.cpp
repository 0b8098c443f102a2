#include "server/net/tls.h"

#include <openssl/err.h>

#include <string_view>
#include <utility>

namespace rivage::server {
namespace {

using core::ErrorCode;
using core::fail;

/// The reason that OpenSSL gives for its last failure.
std::string reason() {
    const char* text = ::ERR_reason_error_string(::ERR_peek_last_error());
    ::ERR_clear_error();
    return text ? text : "unknown reason";
}

int chooseProtocol(SSL*, const unsigned char** chosen, unsigned char* size,
                   const unsigned char* offered, unsigned int offeredSize, void*) {
    static constexpr unsigned char kOurs[] = {8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
    unsigned char* match = nullptr;
    const int result =
        ::SSL_select_next_proto(&match, size, kOurs, sizeof kOurs, offered, offeredSize);
    *chosen = match;
    return result == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_NOACK;
}

void setRules(SSL_CTX* context) {
    ::SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    ::SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE |
                                       SSL_OP_NO_COMPRESSION | SSL_OP_IGNORE_UNEXPECTED_EOF);
    // What the socket did not take may be offered again from another address, and idle connections
    // hold no buffers.
    ::SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE |
                                    SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
    constexpr std::string_view kName = "rivage";
    ::SSL_CTX_set_session_id_context(context, reinterpret_cast<const unsigned char*>(kName.data()),
                                     static_cast<unsigned>(kName.size()));
    ::SSL_CTX_set_alpn_select_cb(context, &chooseProtocol, nullptr);
}

}  // namespace

core::Result<TlsContext::Context> TlsContext::read() const {
    ::ERR_clear_error();
    Context context(::SSL_CTX_new(::TLS_server_method()));
    if (!context) return fail(ErrorCode::internal, "TLS cannot be set up: " + reason());
    setRules(context.get());
    if (::SSL_CTX_use_certificate_chain_file(context.get(), certificate_.c_str()) != 1)
        return fail(ErrorCode::invalidOption,
                    "--tls-cert: " + certificate_ + " is no PEM certificate: " + reason());
    if (::SSL_CTX_use_PrivateKey_file(context.get(), key_.c_str(), SSL_FILETYPE_PEM) != 1 ||
        ::SSL_CTX_check_private_key(context.get()) != 1)
        return fail(ErrorCode::invalidOption,
                    "--tls-key: " + key_ + " is no PEM key of the certificate: " + reason());
    return context;
}

core::Result<std::unique_ptr<TlsContext>> TlsContext::load(std::string certificate,
                                                           std::string key) {
    std::unique_ptr<TlsContext> tls(new TlsContext(std::move(certificate), std::move(key)));
    if (auto read = tls->reload(); !read) return fail(read.error());
    return tls;
}

core::Result<void> TlsContext::reload() {
    auto context = read();
    if (!context) return fail(context.error());
    const std::lock_guard lock(mutex_);
    context_ = *std::move(context);
    return {};
}

SslPointer TlsContext::session(int socket) const {
    const std::lock_guard lock(mutex_);
    SslPointer ssl(::SSL_new(context_.get()));
    if (!ssl || ::SSL_set_fd(ssl.get(), socket) != 1) return nullptr;
    ::SSL_set_accept_state(ssl.get());
    return ssl;
}

}  // namespace rivage::server
