#include "server/net/tls.h"

#include <doctest/doctest.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <vector>

#include "tests/server/net/net_server.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;
using server::NetLimits;
using server::Phase;
using server::TlsContext;

namespace {

struct KeyDelete {
    void operator()(EVP_PKEY* key) const { ::EVP_PKEY_free(key); }
    void operator()(X509* certificate) const { ::X509_free(certificate); }
    void operator()(std::FILE* file) const { std::fclose(file); }
};

/// A fresh self-signed certificate in files that are gone at the end.
class Certificate {
public:
    Certificate() {
        folder_ = (std::filesystem::temp_directory_path() / "rivage-tls-XXXXXX").string();
        REQUIRE(::mkdtemp(folder_.data()) != nullptr);
        renew();
    }
    ~Certificate() { std::filesystem::remove_all(folder_); }
    [[nodiscard]] std::string certificate() const { return folder_ + "/cert.pem"; }
    [[nodiscard]] std::string key() const { return folder_ + "/key.pem"; }

    void renew() const {
        const std::unique_ptr<EVP_PKEY, KeyDelete> key(::EVP_EC_gen("P-256"));
        const std::unique_ptr<X509, KeyDelete> x509(::X509_new());
        ::ASN1_INTEGER_set(::X509_get_serialNumber(x509.get()), 1);
        ::X509_gmtime_adj(::X509_getm_notBefore(x509.get()), 0);
        ::X509_gmtime_adj(::X509_getm_notAfter(x509.get()), 3600);
        ::X509_set_pubkey(x509.get(), key.get());
        X509_NAME* name = ::X509_get_subject_name(x509.get());
        const auto* text = reinterpret_cast<const unsigned char*>("localhost");
        ::X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, text, -1, -1, 0);
        ::X509_set_issuer_name(x509.get(), name);
        REQUIRE(::X509_sign(x509.get(), key.get(), ::EVP_sha256()) > 0);
        const std::unique_ptr<std::FILE, KeyDelete> out(std::fopen(certificate().c_str(), "w"));
        const std::unique_ptr<std::FILE, KeyDelete> outKey(std::fopen(this->key().c_str(), "w"));
        ::PEM_write_X509(out.get(), x509.get());
        ::PEM_write_PrivateKey(outKey.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr);
    }

private:
    std::string folder_;
};

std::unique_ptr<httplib::SSLClient> secureClient(const server::Address& address) {
    auto client = std::make_unique<httplib::SSLClient>(address.host, address.port);
    client->enable_server_certificate_verification(false);
    client->set_keep_alive(true);
    client->set_read_timeout(20s);
    return client;
}

}  // namespace

TEST_SUITE_BEGIN("server/net");

TEST_CASE("TLS: requests, bodies, large answers and keep-alive") {
    const Certificate certificate;
    const auto tls = TlsContext::load(certificate.certificate(), certificate.key());
    REQUIRE(tls);
    const NetServer server({}, tls->get());
    const auto client = secureClient(server.address);
    for (int i = 0; i < 3; ++i) {
        const auto quick = client->Get("/quick");
        REQUIRE(quick);
        CHECK(quick->body == "quick");
    }
    const auto upload = client->Post("/upload", std::string(3000000, 'x'), "text/plain");
    REQUIRE(upload);
    CHECK(upload->body == "3000000");
    for (const char* path : {"/lent", "/copied"}) {
        const auto big = client->Get(path);
        REQUIRE(big);
        CHECK(big->body == *server.big);
    }
    CHECK(server.front->stats().accepted == 1);
}

TEST_CASE("TLS: silent and broken handshakes hold no thread and end") {
    const Certificate certificate;
    const auto tls = TlsContext::load(certificate.certificate(), certificate.key());
    NetLimits limits;
    limits.headTimeout = 500ms;
    const NetServer server(limits, tls->get());
    std::vector<std::unique_ptr<RawClient>> silent;
    for (int i = 0; i < 50; ++i) silent.push_back(std::make_unique<RawClient>(server.address));
    RawClient plain(server.address);
    plain.send(get("/quick"));
    CHECK(statusOf(plain.readAll(2s)) == 0);
    const auto began = std::chrono::steady_clock::now();
    const auto client = secureClient(server.address);
    CHECK(client->Get("/quick"));
    CHECK(std::chrono::steady_clock::now() - began < 300ms);
    for (const auto& connection : silent) CHECK(connection->closedWithin(2s));
    CHECK(server.front->stats().timedOut == 50);
}

TEST_CASE("TLS: a client that leaves is seen") {
    const Certificate certificate;
    const auto tls = TlsContext::load(certificate.certificate(), certificate.key());
    const NetServer server({}, tls->get());
    const auto client = secureClient(server.address);
    std::thread leaver([&] {
        CHECK(eventually([&] { return server.running == 1; }));
        client->stop();
    });
    CHECK_FALSE(client->Get("/watch"));
    leaver.join();
    CHECK(eventually([&] { return server.gone == 1; }));
}

TEST_CASE("TLS: files that are wrong are named by their flag; a reload keeps the old on failure") {
    const Certificate certificate;
    const Certificate other;
    const auto wrong = TlsContext::load("/no/such/file", certificate.key());
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().message.find("--tls-cert") != std::string::npos);
    const auto mismatch = TlsContext::load(certificate.certificate(), other.key());
    REQUIRE_FALSE(mismatch);
    CHECK(mismatch.error().message.find("--tls-key") != std::string::npos);

    const auto tls = TlsContext::load(certificate.certificate(), certificate.key());
    REQUIRE(tls);
    const NetServer server({}, tls->get());
    certificate.renew();
    CHECK((*tls)->reload());
    const auto client = secureClient(server.address);
    CHECK(client->Get("/quick"));
    std::filesystem::remove(certificate.key());
    CHECK_FALSE((*tls)->reload());
    const auto again = secureClient(server.address);
    CHECK(again->Get("/quick"));
}

TEST_SUITE_END();
