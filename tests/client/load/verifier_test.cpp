#include "client/load/verifier.h"

#include <doctest/doctest.h>

namespace rivage::client::load {
namespace {

std::string number(std::uint32_t value) {
    std::string bytes;
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xff);
    return bytes;
}

std::string glb(const std::string& json, const std::string& binary) {
    const auto size = [](const std::string& text) {
        return number(static_cast<std::uint32_t>(text.size()));
    };
    const std::string chunks =
        size(json) + "JSON" + json + size(binary) + std::string("BIN\0", 4) + binary;
    return "glTF" + number(2) + number(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

const std::string kJson = R"({"asset":{"version":"2.0"}}  )";

TEST_SUITE("client/load") {
    TEST_CASE("verifier: a GLB is known by its lengths and its JSON") {
        static_assert(sizeof(std::uint32_t) == 4);
        const std::string padded = kJson + std::string((4 - kJson.size() % 4) % 4, ' ');
        const std::string good = glb(padded, "12345678");
        CHECK(isGlb(good));
        for (std::size_t size = 0; size < good.size(); ++size)
            CHECK_FALSE(isGlb(good.substr(0, size)));
        CHECK_FALSE(isGlb(good + "0000"));
        CHECK_FALSE(isGlb(glb("[1] ", "12345678")));
        CHECK_FALSE(isGlb(glb("{\"a\"", "12345678")));
        CHECK_FALSE(isGlb("glTX" + good.substr(4)));
        const std::string deep = "{\"asset\":" + std::string(1'000'000, '[');
        CHECK_FALSE(isGlb(glb(deep + std::string(2 + 4 - deep.size() % 4, ' '), "")));
    }

    TEST_CASE("verifier: digests are those of RFC 9530") {
        CHECK(digestOf("{\"hello\": \"world\"}\n") ==
              "sha-256=:RK/0qy18MlBSVnWgjwz6lZEWjP/lF5HF9bvEF8FabDg=:");
        VerifySample sample{.type = "text/plain", .digest = digestOf("abc"), .body = "abc"};
        CHECK(faultOf(sample).empty());
        sample.digest = "md5=:AAAA:, " + digestOf("abc") + ", other=1";
        CHECK(faultOf(sample).empty());
        sample.body = "abd";
        CHECK(faultOf(sample) == "digest-mismatch");
        sample.digest.clear();
        CHECK(faultOf(sample).empty());
        sample.type = "model/gltf-binary";
        CHECK(faultOf(sample) == "invalid-glb");
    }

    TEST_CASE("verifier: answers of one entry have to be the same") {
        Verifier verifier;
        for (const char* body : {"a", "a", "b"})
            verifier.look({.entry = 0, .same = true, .type = "text/plain", .body = body});
        verifier.look({.entry = 1, .same = true, .type = "text/plain", .body = "c"});
        verifier.look({.entry = 2, .same = false, .type = "text/plain", .body = "d"});
        verifier.look({.entry = 2, .same = false, .type = "text/plain", .body = "e"});
        verifier.finish();
        CHECK(verifier.verified() == 6);
        CHECK(verifier.faults() == std::map<std::string, std::uint64_t>{{"different-result", 1}});
    }
}

}  // namespace
}  // namespace rivage::client::load
