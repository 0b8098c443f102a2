#include <doctest/doctest.h>

#include "tests/server/test_server.h"

using namespace rivage;
using namespace rivage::test;

namespace {

const std::string kPage = "https://page.example";

httplib::Result preflight(const TestServer& server, const std::string& path,
                          const std::string& origin) {
    httplib::Request request;
    request.method = "OPTIONS";
    request.path = path;
    request.set_header("Origin", origin);
    request.set_header("Access-Control-Request-Method", "POST");
    return server.client().send(request);
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("CORS: off without origins") {
    const TestServer server;
    const auto answer = server.client().Get("/version", httplib::Headers{{"Origin", kPage}});
    REQUIRE(answer);
    CHECK_FALSE(answer->has_header("Access-Control-Allow-Origin"));
    CHECK(answer->get_header_value("Vary").find("Origin") == std::string::npos);
    const auto asked = preflight(server, "/v1/jobs", kPage);
    REQUIRE(asked);
    CHECK(asked->status == 204);
    CHECK_FALSE(asked->has_header("Access-Control-Allow-Methods"));
}

TEST_CASE("CORS: a preflight is answered without a key, and says what may be sent") {
    const TestServer server(
        {.keys = "a sha256:" + std::string(64, '0'), .corsOrigins = {"https://x", kPage}});
    const auto answer = preflight(server, "/v1/jobs", kPage);
    REQUIRE(answer);
    CHECK(answer->status == 204);
    CHECK(answer->get_header_value("Access-Control-Allow-Origin") == kPage);
    CHECK(answer->get_header_value("Access-Control-Allow-Methods") == "POST, GET, HEAD, OPTIONS");
    CHECK(answer->get_header_value("Access-Control-Allow-Headers").find("Idempotency-Key") !=
          std::string::npos);
    CHECK(answer->get_header_value("Access-Control-Max-Age") == "600");
    CHECK(answer->get_header_value("Vary") == "Origin");
    CHECK_FALSE(answer->has_header("Access-Control-Allow-Credentials"));
    checkProblem(preflight(server, "/v1/nothing", kPage), 404, "not-found");
}

TEST_CASE("CORS: only exact origins, on errors too") {
    const TestServer server({.corsOrigins = {kPage}});
    auto client = server.client();
    for (const char* path : {"/v1/limits", "/v1/jobs/none", "/nothing", "/version"}) {
        const auto answer = client.Get(path, httplib::Headers{{"Origin", kPage}});
        REQUIRE(answer);
        CHECK(answer->get_header_value("Access-Control-Allow-Origin") == kPage);
        CHECK(answer->get_header_value("Access-Control-Expose-Headers").find("ETag") !=
              std::string::npos);
        CHECK(answer->get_header_value("Vary") == "Origin");
        CHECK(answer->get_header_value_count("Access-Control-Allow-Origin") == 1);
    }
    for (const std::string& origin :
         {std::string("null"), kPage + ":443", std::string("http://page.example"), kPage + ".evil",
          std::string("https://PAGE.example"), std::string("*")}) {
        const auto answer = client.Get("/version", httplib::Headers{{"Origin", origin}});
        REQUIRE(answer);
        CHECK_FALSE(answer->has_header("Access-Control-Allow-Origin"));
        CHECK(answer->get_header_value("Vary") == "Origin");
        CHECK_FALSE(
            preflight(server, "/v1/jobs", origin)->has_header("Access-Control-Allow-Methods"));
    }
}

TEST_SUITE_END();
