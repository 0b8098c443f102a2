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
          "http://a:65536", "http://a:8x", "http://a/path", "unix:", "http://[::1", "http://::1",
          "http://[::1]8", "http://[x]", "http://[]:80", "http://a]b", "http://a b", "http://a:"}) {
        CAPTURE(text);
        const auto endpoint = parseEndpoint(text);
        REQUIRE_FALSE(endpoint);
        CHECK(endpoint.error().exit == ExitCode::usage);
    }
    CHECK_FALSE(parseEndpoint("unix:/" + std::string(107, 'x')));
    CHECK(parseEndpoint("unix:/" + std::string(106, 'x')));
    CHECK(describe(parseEndpoint("http://::1").error()).find("in brackets") != std::string::npos);
}

TEST_CASE("reject: a password in an address, which no words show") {
    for (const char* text : {"http://me:secret@a:80", "https://secret@a", "ftp://me:secret@a",
                             "http://me:secret@[::1", "me:secret@a"}) {
        CAPTURE(text);
        const auto endpoint = parseEndpoint(text);
        REQUIRE_FALSE(endpoint);
        CHECK(endpoint.error().exit == ExitCode::usage);
        CHECK(describe(endpoint.error()).find("secret") == std::string::npos);
    }
    CHECK(parseEndpoint("unix:/run/a@b"));
}

TEST_CASE("endpoint: what stays on this machine") {
    for (const char* text : {"http://127.0.0.1:1", "http://127.9.9.9", "http://localhost",
                             "http://[::1]", "http://[::ffff:127.0.0.1]", "unix:/a"})
        CHECK_MESSAGE(isLoopback(*parseEndpoint(text)), text);
    for (const char* text : {"http://128.0.0.1", "http://127.example.org", "http://[::2]",
                             "http://localhost.example.org", "http://[::ffff:10.0.0.1]"})
        CHECK_MESSAGE(!isLoopback(*parseEndpoint(text)), text);
}

TEST_SUITE_END();

}  // namespace rivage::client
