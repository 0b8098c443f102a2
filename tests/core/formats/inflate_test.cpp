#include "core/formats/inflate.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/packed.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::packed;
using rivage::test::VoxBuilder;

namespace {

Result<std::vector<std::byte>> unpacked(const std::string& bytes, std::uint64_t most,
                                        const RunContext& run = {}) {
    return inflateUpTo(VoxBuilder::toBytes(bytes), most, run);
}

std::string textOf(const Result<std::vector<std::byte>>& bytes) {
    REQUIRE(bytes);
    return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

/// Bytes that pack, but not to nothing.
std::string someBytes(std::size_t size) {
    std::string text;
    while (text.size() < size) text += std::to_string(text.size() * 7919 % 1000);
    return text.substr(0, size);
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("inflate: gzip and zlib, of any size, up to a bound") {
    for (const std::size_t size : {0U, 1U, 65535U, 65536U, 65537U, 5'000'000U}) {
        CAPTURE(size);
        const std::string text = someBytes(size);
        for (const bool gzip : {true, false}) {
            CHECK((textOf(unpacked(packed(text, gzip), size + 1)) == text));
            CHECK((textOf(unpacked(packed(text, gzip), size)) == text));
            CHECK(textOf(unpacked(packed(text, gzip), size / 2)).size() == size / 2);
        }
    }
}

TEST_CASE("inflate: several members one after the other; what follows them is not looked at") {
    const std::string two = packed("one ") + packed("two");
    CHECK(textOf(unpacked(two, 100)) == "one two");
    CHECK(textOf(unpacked(two + std::string(512, '\0'), 100)) == "one two");
}

TEST_CASE("reject: a stream that breaks off anywhere, or is damaged") {
    const std::string whole = packed(someBytes(3000));
    for (std::size_t size = 0; size < whole.size(); size += 7)
        CHECK_FALSE(unpacked(whole.substr(0, size), 3001));
    std::string damaged = whole;
    damaged[damaged.size() - 6] ^= 1;  // the checksum
    CHECK_FALSE(unpacked(damaged, 3001));
    CHECK(unpacked("hello", 10).error().code == ErrorCode::malformedInput);
}

TEST_CASE("reject: a stop ends unpacking") {
    const auto stopped =
        unpacked(packed(someBytes(100)), 101, {.stopRequested = [] { return true; }});
    REQUIRE_FALSE(stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
}
