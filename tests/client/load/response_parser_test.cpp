#include "client/load/response_parser.h"

#include <doctest/doctest.h>

#include <vector>

namespace rivage::client::load {
namespace {

/// Feeds pieces of one size. @return how many bytes were taken
std::size_t feed(ResponseParser& parser, std::string_view bytes, std::size_t piece) {
    std::size_t used = 0;
    while (used < bytes.size() && !parser.done() && !parser.malformed()) {
        const std::size_t taken = parser.feed(bytes.substr(used, piece));
        if (taken == 0) break;
        used += taken;
    }
    return used;
}

ResponseParser parsed(std::string_view bytes, std::size_t piece = 1 << 20) {
    ResponseParser parser;
    parser.reset(Keep::all);
    feed(parser, bytes, piece);
    return parser;
}

const char* const kLength = "HTTP/1.1 200 OK\r\nContent-Length: 5\r\nX-One:  a b \r\n\r\nhello";
const char* const kChunked =
    "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"
    "3;name=value\r\nhel\r\n00002\r\nlo\r\n0\r\nTrailer: x\r\n\r\n";
const char* const kInterim =
    "HTTP/1.1 100 Continue\r\n\r\nHTTP/1.1 103 Early Hints\r\nLink: x\r\n\r\n"
    "HTTP/1.1 200 OK\r\ncontent-length: 5\r\n\r\nhello";

TEST_SUITE("client/load") {
    TEST_CASE("parser: the same answer, whatever pieces it comes in") {
        for (const char* text : {kLength, kChunked, kInterim})
            for (std::size_t piece = 1; piece < 60; ++piece) {
                CAPTURE(text);
                CAPTURE(piece);
                const ResponseParser parser = parsed(text, piece);
                CHECK(parser.reusable());
                CHECK(parser.status() == 200);
                CHECK(parser.body() == "hello");
                CHECK(parser.bodySize() == 5);
            }
        CHECK(parsed(kLength).field("x-ONE") == "a b");
        CHECK(parsed(kLength).field("x-two").empty());
    }

    TEST_CASE("parser: each proper prefix is not whole") {
        for (const std::string_view text : {kLength, kChunked, kInterim})
            for (std::size_t size = 0; size < text.size(); ++size) {
                CAPTURE(size);
                ResponseParser parser = parsed(text.substr(0, size));
                CHECK_FALSE(parser.done());
                CHECK_FALSE(parser.malformed());
                CHECK_FALSE(parser.finish());
            }
    }

    TEST_CASE("parser: stops at the end of an answer") {
        ResponseParser parser;
        parser.reset(Keep::all);
        const std::string two = std::string(kLength) + kChunked;
        CHECK(parser.feed(two) == std::string_view(kLength).size());
    }

    TEST_CASE("parser: a body without a length ends with the connection") {
        ResponseParser parser = parsed("HTTP/1.1 200 OK\r\n\r\nhel");
        CHECK_FALSE(parser.done());
        parser.feed("lo");
        CHECK(parser.finish());
        CHECK(parser.body() == "hello");
        CHECK_FALSE(parser.reusable());
    }

    TEST_CASE("parser: answers without a body") {
        for (const char* text : {"HTTP/1.1 204 No Content\r\n\r\n",
                                 "HTTP/1.1 304 Not Modified\r\nContent-Length: 9\r\n\r\n",
                                 "HTTP/1.1 200\r\nContent-Length: 0\r\n\r\n"}) {
            CAPTURE(text);
            CHECK(parsed(text).reusable());
        }
        ResponseParser head;
        head.reset(Keep::all, true);
        head.feed("HTTP/1.1 200 OK\r\nContent-Length: 5\r\n\r\n");
        CHECK(head.done());
    }

    TEST_CASE("parser: connections that are not to be used again") {
        CHECK_FALSE(parsed("HTTP/1.0 200 OK\r\nContent-Length: 0\r\n\r\n").reusable());
        CHECK(parsed("HTTP/1.0 200 OK\r\nConnection: keep-alive\r\nContent-Length: 0\r\n\r\n")
                  .reusable());
        CHECK_FALSE(parsed("HTTP/1.1 200 OK\r\nConnection: x, Close\r\nContent-Length: 0\r\n\r\n")
                        .reusable());
    }

    TEST_CASE("parser: keeps what it is told to") {
        ResponseParser parser;
        parser.reset(Keep::errors);
        parser.feed(kLength);
        CHECK(parser.body().empty());
        CHECK(parser.bodySize() == 5);
        parser.reset(Keep::errors);
        parser.feed("HTTP/1.1 400 Bad\r\nContent-Length: 3\r\n\r\nbad");
        CHECK(parser.body() == "bad");
        parser.reset(Keep::nothing);
        parser.feed("HTTP/1.1 400 Bad\r\nContent-Length: 3\r\n\r\nbad");
        CHECK(parser.body().empty());
    }

    TEST_CASE("reject: what is no answer") {
        for (const std::string text :
             {"HTTP/2 200\r\n\r\n", "HTTP/1.1 2x0 OK\r\n\r\n", "HTTP/1.1 700 OK\r\n\r\n",
              "SSH-2.0-OpenSSH\r\n\r\n", "HTTP/1.1 200 OK\r\nno colon\r\n\r\n",
              "HTTP/1.1 200 OK\r\nContent-Length: -1\r\n\r\n",
              "HTTP/1.1 200 OK\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
              "HTTP/1.1 200 OK\r\nTransfer-Encoding: gzip\r\n\r\n",
              "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n",
              "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nab\r\n"}) {
            CAPTURE(text);
            CHECK(parsed(text).malformed());
        }
        const std::string endless(ResponseParser::kMaxHead + 1, 'x');
        CHECK(parsed("HTTP/1.1 200 OK\r\nX: " + endless).malformed());
        CHECK(
            parsed("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" + endless).malformed());
    }
}

}  // namespace
}  // namespace rivage::client::load
