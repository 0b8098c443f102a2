#include "client/endpoint.h"

#include <doctest/doctest.h>

namespace rivage::client {

TEST_SUITE_BEGIN("client");

TEST_CASE("endpoint: addresses are read and written back") {
    CHECK(*parseEndpoint("http://127.0.0.1:8080") == Endpoint{"127.0.0.1", 8080});
    CHECK(*parseEndpoint("http://example.org/") == Endpoint{"example.org", 80});
    CHECK(*parseEndpoint("http://[::1]:81") == Endpoint{"::1", 81});
    CHECK(*parseEndpoint("http://[::1]") == Endpoint{"::1", 80});
    CHECK(*parseEndpoint("https://example.org") == Endpoint{"example.org", 443, true});
    CHECK(*parseEndpoint("https://[::1]:8443/") == Endpoint{"::1", 8443, true});
    CHECK(*parseEndpoint("unix:/run/rivage.sock") == Endpoint{"/run/rivage.sock", 0});
    for (const char* text : {"http://a:1", "http://[::1]:81", "https://a:2", "unix:/a"})
        CHECK(toText(*parseEndpoint(text)) == text);
}

TEST_CASE("reject: what is no address") {
    for (const char* text :
         {"", "localhost:80", "https://", "httpss://a", "http://", "http://:80", "http://a:0",
          "http://a:65536", "http://a:8x", "http://a/path", "unix:"}) {
        CAPTURE(text);
        const auto endpoint = parseEndpoint(text);
        REQUIRE_FALSE(endpoint);
        CHECK(endpoint.error().exit == ExitCode::usage);
    }
    CHECK_FALSE(parseEndpoint("unix:/" + std::string(107, 'x')));
    CHECK(parseEndpoint("unix:/" + std::string(106, 'x')));
}

TEST_SUITE_END();

}  // namespace rivage::client
