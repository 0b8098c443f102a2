#include <doctest/doctest.h>

#include <string>

#include "tests/server/test_server.h"
#include "tests/support/packed.h"

using namespace rivage;
using namespace rivage::test;
using namespace std::chrono_literals;

namespace {

constexpr const char* kBytes = "application/octet-stream";
constexpr const char* kRoute = "/v1/regularize";

std::string gzip(const std::string& text) { return packed(text); }

bool isProblem(const std::string& answer, const std::string& status) {
    return answer.starts_with("HTTP/1.1 " + status) &&
           answer.find("application/problem+json") != std::string::npos &&
           answer.find("X-Request-ID: ") != std::string::npos;
}

}  // namespace

TEST_SUITE_BEGIN("server/http");

TEST_CASE("errors: paths and methods that are not there") {
    const TestServer server;
    auto client = server.client();
    for (const char* path : {"/nothing", "/v1", "/v1/", "/v2/jobs", "/v1/jobs/", "/../etc/passwd",
                             "/v1/jobs/a/b/c", "//", "/%00"})
        checkProblem(client.Get(path), 404, "not-found");
    const auto put = client.Put("/v1/jobs", "x", kBytes);
    checkProblem(put, 405, "method-not-allowed");
    CHECK(put->get_header_value("Allow") == "POST, GET, HEAD, OPTIONS");
    checkProblem(client.Get(kRoute), 405, "method-not-allowed");
    checkProblem(client.Post("/version", "", kBytes), 405, "method-not-allowed");
    checkProblem(client.Delete("/"), 405, "method-not-allowed");
    const auto options = client.Options("/v1/limits");
    REQUIRE(options);
    CHECK(options->status == 204);
    CHECK(options->get_header_value("Allow") == "GET, HEAD, OPTIONS");
}

TEST_CASE("errors: what the HTTP layer refuses is a problem too") {
    const TestServer server;
    CHECK(isProblem(server.raw("nonsense\r\n\r\n"), "400"));
    CHECK(isProblem(server.raw("GET / HTTP/9.9\r\n\r\n"), "400"));
    CHECK(isProblem(server.raw("BREW / HTTP/1.1\r\nHost: x\r\n\r\n"), "400"));
    CHECK(isProblem(server.raw("GET /" + std::string(9000, 'x') + " HTTP/1.1\r\n\r\n"), "414"));
    CHECK(isProblem(server.raw("GET / HTTP/1.1\r\nX: " + std::string(9000, 'x')), "431"));
    CHECK(isProblem(server.raw("\x16\x03\x01"), "400"));
    std::string crowd = "GET / HTTP/1.1\r\n";
    for (int i = 0; i < 200; ++i) crowd += "X-" + std::to_string(i) + ": y\r\n";
    CHECK(isProblem(server.raw(crowd + "\r\n"), "431"));
    CHECK(isProblem(server.raw("POST /v1/regularize HTTP/1.1\r\nHost: x\r\n"
                               "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\nok"),
                    "400"));
    CHECK(isProblem(server.raw("POST /v1/regularize HTTP/1.1\r\nHost: x\r\n"
                               "Transfer-Encoding: chunked\r\n\r\n-2\r\nok\r\n0\r\n\r\n"),
                    "400"));
}

TEST_CASE("errors: a body that stops, or comes too slowly") {
    const TestServer server({.readTimeout = 1s});
    const std::string head =
        "POST /v1/regularize HTTP/1.1\r\nHost: x\r\n"
        "Content-Length: 100\r\nConnection: close\r\n\r\n";
    CHECK(isProblem(server.raw(head + "short"), "408"));
    CHECK(isProblem(server.raw(head, std::string(100, 'x')), "408"));
    CHECK(server.pool->idle());
}

TEST_CASE("errors: too many bytes, announced, chunked or inflated") {
    const TestServer server({.maxUpload = 1000});
    auto client = server.client();
    const auto announced = client.Post(kRoute, std::string(1001, 'x'), kBytes);
    checkProblem(announced, 413, "too-large");
    CHECK(bodyOf(announced)["limit"] == 1000);
    CHECK(bodyOf(announced)["actual"] == 1001);
    CHECK(bodyOf(announced)["setting"] == "--max-upload");
    CHECK(client.Post(kRoute, std::string(1000, 'x'), kBytes)->status == 200);

    const auto chunked = client.Post(
        kRoute,
        [](std::size_t, httplib::DataSink& sink) {
            const std::string piece(4096, 'x');
            return sink.write(piece.data(), piece.size());
        },
        kBytes);
    if (chunked) checkProblem(chunked, 413, "too-large");

    checkProblem(
        client.Post(kRoute, {{"Content-Encoding", "gzip"}}, gzip(std::string(100000, 'x')), kBytes),
        413, "too-large");
    httplib::UploadFormDataItems items{{"grid", std::string(1001, 'x'), "a.vox", kBytes}};
    checkProblem(client.Post(kRoute, items), 413, "too-large");
}

TEST_CASE("errors: a chunked body of any length is refused at the limit, over a raw socket") {
    const TestServer server({.maxUpload = 1000});
    std::string request =
        "POST /v1/regularize HTTP/1.1\r\nHost: x\r\n"
        "Transfer-Encoding: chunked\r\n\r\n";
    for (int i = 0; i < 2; ++i) request += "400\r\n" + std::string(1024, 'x') + "\r\n";
    CHECK(isProblem(server.raw(request), "413"));
}

TEST_CASE("errors: encodings") {
    const TestServer server;
    auto client = server.client();
    const auto packed = client.Post(kRoute, {{"Content-Encoding", "gzip"}}, gzip("ok"), kBytes);
    REQUIRE(packed);
    CHECK(packed->body == "asset of ok");
    CHECK(client.Post(kRoute, {{"Content-Encoding", "identity"}}, "ok", kBytes)->status == 200);
    for (const char* encoding : {"br", "gzip, gzip", "rot13"})
        checkProblem(client.Post(kRoute, {{"Content-Encoding", encoding}}, "ok", kBytes), 415,
                     "unsupported-encoding");
    checkProblem(client.Post(kRoute, {{"Content-Encoding", "gzip"}}, "no gzip", kBytes), 400,
                 "malformed-request");
}

TEST_CASE("errors: a request id is taken if it is harmless, else made") {
    const TestServer server;
    auto client = server.client();
    const auto id = [&](const std::string& sent) {
        const auto result = client.Get("/version", httplib::Headers{{"X-Request-ID", sent}});
        REQUIRE(result);
        return result->get_header_value("X-Request-ID");
    };
    CHECK(id("abc-DEF_123") == "abc-DEF_123");
    CHECK(id("a b") != "a b");
    CHECK(id(std::string(65, 'a')).size() == 24);
    CHECK(id("") != id(""));
}

TEST_SUITE_END();
