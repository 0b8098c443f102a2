#include "core/formats/clean_text.h"

#include <doctest/doctest.h>

#include <string>

using namespace rivage::core;

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("clean text: valid UTF-8 stays as it is") {
    CHECK(cleanText("roof 1") == "roof 1");
    CHECK(cleanText("\xc3\xa9t\xc3\xa9 \xe6\xb5\xb7 \xf0\x9f\x8f\xa0") ==
          "\xc3\xa9t\xc3\xa9 \xe6\xb5\xb7 \xf0\x9f\x8f\xa0");
}

TEST_CASE("clean text: what JSON could not carry becomes a question mark") {
    CHECK(cleanText("a\nb\x7f") == "a?b?");
    CHECK(cleanText("\xff\xfe") == "??");
    CHECK(cleanText("\xc0\xaf") == "??");            // overlong
    CHECK(cleanText("\xed\xa0\x80") == "???");       // surrogate
    CHECK(cleanText("\xf4\x90\x80\x80") == "????");  // above U+10FFFF
    CHECK(cleanText("a\xe6\xb5") == "a??");          // cut short
}

TEST_CASE("clean text: long names are cut between characters") {
    CHECK(cleanText(std::string(1000, 'x')).size() == kMaxTextBytes);
    std::string wide = "x";
    for (int i = 0; i < 100; ++i) wide += "\xc3\xa9";
    CHECK(cleanText(wide).size() == kMaxTextBytes - 1);
}

TEST_SUITE_END();
