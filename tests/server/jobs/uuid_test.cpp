#include "server/jobs/uuid.h"

#include <doctest/doctest.h>

#include <set>

#include "server/jobs/digest.h"

using namespace rivage::server;

TEST_SUITE_BEGIN("server/jobs");

TEST_CASE("UuidSource: version 7, all different, in the order in which they were made") {
    UuidSource source;
    const auto now = std::chrono::system_clock::now();
    std::string last;
    for (int i = 0; i < 20000; ++i) {  // more than a millisecond has room for
        const std::string id = source.next(now);
        if (i == 0) CHECK(looksLikeUuid(id));
        REQUIRE(id[14] == '7');
        REQUIRE(std::string("89ab").find(id[19]) != std::string::npos);
        REQUIRE(id > last);
        last = id;
    }
}

TEST_CASE("looksLikeUuid: nothing else passes") {
    CHECK(looksLikeUuid("01234567-89ab-7def-8123-456789abcdef"));
    for (const char* text :
         {"", "01234567-89ab-7def-8123-456789abcde", "01234567-89AB-7def-8123-456789abcdef",
          "01234567x89ab-7def-8123-456789abcdef", "../../../../etc/passwd/0000000000000"})
        CHECK_FALSE(looksLikeUuid(text));
}

TEST_CASE("sha256: the known digest of no bytes, in both forms") {
    const Digest digest = sha256({});
    CHECK(digest.hex == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(digest.base64 == "47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=");
}

TEST_SUITE_END();
