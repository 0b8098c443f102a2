#include "server/keys/api_keys.h"

#include <doctest/doctest.h>

#include <string>

using namespace rivage::server;
using namespace std::chrono_literals;

namespace {

const std::string kHashA = "sha256:" + std::string(64, 'a');
const std::string kHashB = "sha256:" + std::string(64, 'B');

std::string mistake(const std::string& text) {
    const auto ring = KeyRing::parse(text);
    return ring ? std::string() : ring.error().message;
}

}  // namespace

TEST_SUITE_BEGIN("server/keys");

TEST_CASE("KeyRing: reads names, hashes, quotas and dates; comments and blank lines are nothing") {
    const auto ring = KeyRing::parse(
        "# all keys\n\n  anna " + kHashA +
        " rate=60/m jobs=4 expires=2027-01-31 # the first\r\nbob.b-1\t" + kHashB + " disabled");
    REQUIRE(ring);
    REQUIRE(ring->keys().size() == 2);
    const ApiKey& anna = ring->keys()[0];
    CHECK(anna.name == "anna");
    CHECK(anna.hash[31] == 0xaa);
    CHECK(anna.quota.requests == 60);
    CHECK(anna.quota.window == 60s);
    CHECK(anna.quota.jobs == 4);
    const auto end = std::chrono::sys_days(std::chrono::year(2027) / 2 / 1);
    CHECK(anna.usable(end - 1s));
    CHECK_FALSE(anna.usable(end));
    CHECK(ring->keys()[1].name == "bob.b-1");
    CHECK_FALSE(ring->keys()[1].usable(end));
    CHECK(KeyRing::parse("").value().keys().empty());
}

TEST_CASE("KeyRing: windows are seconds, minutes and hours") {
    for (const auto& [text, window] : {std::pair{"1/s", 1s}, {"1/m", 60s}, {"1/h", 3600s}})
        CHECK(KeyRing::parse("a " + kHashA + " rate=" + text).value().keys()[0].quota.window ==
              window);
}

TEST_CASE("reject: key files, with the line and without the hash in the message") {
    for (const std::string& tail :
         {std::string(" rate=0/m"), std::string(" rate=5/d"), std::string(" rate=5"),
          std::string(" rate=-1/m"), std::string(" rate=1e9/m"), std::string(" jobs=0"),
          std::string(" jobs=x"), std::string(" expires=2027-02-30"), std::string(" expires=soon"),
          std::string(" expires=2027-1-031"), std::string(" admin"), std::string("a"),
          std::string(" rate=5/m/")}) {
        CAPTURE(tail);
        const std::string message = mistake("\na " + kHashA + tail);
        CHECK(message.starts_with("line 2: "));
        CHECK(message.find("aaaa") == std::string::npos);
    }
    for (const char* line : {"a", "a sha256:abc", "a md5:00", "b\x01 x", "a sha256:"})
        CHECK(mistake(line).starts_with("line 1: "));
    CHECK(mistake(std::string(65, 'n') + " " + kHashA).starts_with("line 1: "));
    CHECK(mistake("a " + kHashA + "\na " + kHashB).find("twice") != std::string::npos);
    CHECK(mistake("a " + kHashA + "\nb " + kHashA).find("that of a") != std::string::npos);
    CHECK_FALSE(KeyRing::load("/does/not/exist"));
    CHECK_FALSE(KeyRing::load("/tmp"));
}

TEST_CASE("KeyRing: finds the holder of a key, wherever it stands") {
    std::string text;
    const auto key = [](int i) { return "a key of sixteen-" + std::to_string(i); };
    CHECK_FALSE(keyLine("n", key(1)));  // a space is not visible
    const auto secret = [](int i) { return "key-of-sixteen-" + std::to_string(i); };
    for (int i = 0; i < 5; ++i) text += keyLine("n" + std::to_string(i), secret(i)).value() + "\n";
    const KeyRing ring = KeyRing::parse(text).value();
    for (int i = 0; i < 5; ++i) {
        REQUIRE(ring.find(secret(i)));
        CHECK(ring.find(secret(i))->name == "n" + std::to_string(i));
    }
    for (const std::string& wrong : {std::string(), std::string("key-of-sixteen-"), secret(5)})
        CHECK(ring.find(wrong) == nullptr);
}

TEST_CASE("reject: keyLine of short and odd keys") {
    CHECK(keyLine("a", "0123456789abcdef"));
    for (const char* key : {"", "0123456789abcde", "0123456789abcde\n0", "0123456789abcd\xc3\xa9"})
        CHECK_FALSE(keyLine("a", key));
    CHECK_FALSE(keyLine("a b", "0123456789abcdef"));
}

TEST_SUITE_END();
