#include "server/net/head_scanner.h"

#include <doctest/doctest.h>

#include <string>

using namespace rivage::server;

namespace {

/// The verdict on bytes that come one by one; it must be the same as if they came at once.
HeadVerdict verdictOn(const std::string& bytes, const NetLimits& limits = {}) {
    HeadScanner atOnce;
    const HeadVerdict expected = atOnce.scan(bytes, limits);
    HeadScanner scanner;
    HeadVerdict verdict;
    for (std::size_t n = 1; n <= bytes.size() && !verdict.complete && verdict.status == 0; ++n)
        verdict = scanner.scan(std::string_view(bytes).substr(0, n), limits);
    CHECK(verdict.complete == expected.complete);
    CHECK(verdict.status == expected.status);
    if (verdict.complete) CHECK(scanner.size() == atOnce.size());
    return verdict;
}

const std::string kStart = "POST / HTTP/1.1\r\nHost: x\r\n";

}  // namespace

TEST_SUITE_BEGIN("server/net");

TEST_CASE("HeadScanner: finds the end of a head, and leaves what follows") {
    HeadScanner scanner;
    CHECK(scanner.scan(kStart + "\r\nbody", {}).complete);
    CHECK(scanner.size() == kStart.size() + 2);
    CHECK(verdictOn(kStart + "Content-Length: 5\r\n\r\n").complete);
    for (std::size_t n = 0; n < kStart.size() + 2; ++n) {
        const HeadVerdict prefix = verdictOn((kStart + "\r\n").substr(0, n));
        CHECK_FALSE(prefix.complete);
        CHECK(prefix.status == 0);
    }
}

TEST_CASE("reject: heads that parsers read in different ways") {
    for (const std::string& head :
         {std::string("\x16\x03\x01"), std::string("get / HTTP/1.1\r\n"), std::string(" GET /"),
          std::string("GET / HTTP/1.1\n"), kStart + "A: b\n", kStart + "A: b\rc: d\r\n",
          kStart + " folded\r\n", kStart + "\tfolded\r\n", kStart + "A: " + std::string(1, '\0'),
          kStart + "A: \x7f", kStart + "Content-Length: 1\r\ncontent-length: 1\r\n",
          kStart + "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n",
          kStart + "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
          kStart + "Content-Length: 3x\r\n", kStart + "Content-Length: +3\r\n",
          kStart + "Content-Length:\r\n", kStart + "Content-Length: 99999999999999999999\r\n"}) {
        CAPTURE(head);
        CHECK(verdictOn(head).status == 400);
    }
}

TEST_CASE("reject: no host, two hosts, more than one coding, a request line that is none") {
    CHECK(verdictOn("GET / HTTP/1.0\r\n\r\n").complete);
    CHECK(verdictOn("GET / HTTP/1.1\r\nhOST: x\r\n\r\n").complete);
    for (const char* head :
         {"GET / HTTP/1.1\r\n\r\n", "GET / HTTP/1.1\r\nHost: x\r\nHost: x\r\n",
          "GET  / HTTP/1.1\r\n", "GET /\r\n",
          "GET / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked, chunked\r\n"}) {
        CAPTURE(head);
        CHECK(verdictOn(head).status == 400);
    }
}

TEST_CASE("reject: each limit of a head, and the limit itself is not refused") {
    NetLimits limits;
    limits.lineBytes = 40;
    limits.headBytes = 200;
    limits.headers = 5;
    const auto line = [](std::size_t size) { return "A: " + std::string(size - 5, 'a') + "\r\n"; };
    CHECK(verdictOn("GET /" + std::string(24, 'x') + " HTTP/1.0\r\n\r\n", limits).complete);
    CHECK(verdictOn("GET /" + std::string(25, 'x') + " HTTP/1.0\r\n\r\n", limits).status == 414);
    const std::string start = "GET / HTTP/1.0\r\n";
    CHECK(verdictOn(start + line(40) + "\r\n", limits).complete);
    CHECK(verdictOn(start + line(41) + "\r\n", limits).status == 431);
    const std::string five = line(6) + line(6) + line(6) + line(6) + line(6);
    CHECK(verdictOn(start + five + "\r\n", limits).complete);
    CHECK(verdictOn(start + five + line(6) + "\r\n", limits).status == 431);
    const std::string long4 = line(40) + line(40) + line(40) + line(40);
    CHECK(verdictOn(start + long4 + line(22) + "\r\n", limits).complete);
    CHECK(verdictOn(start + long4 + line(23) + "\r\n", limits).status == 431);
    CHECK(verdictOn(std::string(41, 'X'), limits).status == 414);
}

TEST_SUITE_END();
