#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "tests/proto/option_checks.h"

using namespace rivage;
using core::ErrorCode;
using proto::JobOptions;
using proto::Json;
using proto::OptionText;
using namespace rivage::test;

TEST_SUITE_BEGIN("proto");

TEST_CASE("parseOptions: height tiles by material, as text and as JSON") {
    const std::string map = R"({"plaster":"brick","9":{"tile":"planks","size":6,"turn":90},)"
                            R"("*":{"height":[[0,0.5],[1,0]],"depth":0.1}})";
    const auto fromText = parse({{"emboss", map}, {"emboss_detail", "8"}});
    REQUIRE(fromText);
    const core::EmbossOptions& emboss = fromText->conversion.emboss;
    REQUIRE(emboss.rules.size() == 3);
    CHECK(emboss.detail == 8);
    CHECK(emboss.rules[0].material == "plaster");
    CHECK(emboss.rules[0].tile.kind == core::TileKind::brick);
    CHECK_FALSE(emboss.rules[0].tile.size);
    CHECK(emboss.rules[1].tile.kind == core::TileKind::planks);
    CHECK(emboss.rules[1].tile.size == 6);
    CHECK(emboss.rules[1].tile.turn == 90);
    CHECK(emboss.rules[2].tile.kind == core::TileKind::own);
    CHECK(emboss.rules[2].tile.heights == std::vector<std::vector<double>>{{0, 0.5}, {1, 0}});
    CHECK(emboss.rules[2].tile.depth == 0.1);
    const auto fromJson = parse({}, R"({"emboss_detail":8,"emboss":)" + map + "}");
    REQUIRE(fromJson);
    CHECK(proto::toJson(*fromText) == proto::toJson(*fromJson));
}

TEST_CASE("parseOptions: a tile for everything is a word, none is no relief") {
    for (const char* word : {"brick", "planks", "shingles", "pantiles", "cobble", "panels"}) {
        const auto options = parse({{"emboss", word}, {"emboss_method", "displace"}});
        REQUIRE(options);
        REQUIRE(options->conversion.emboss.rules.size() == 1);
        CHECK(options->conversion.emboss.rules[0].material == "*");
        CHECK(valueOf(*options, "emboss") == word);
        CHECK(valueOf(*options, "emboss_method") == "displace");
    }
    CHECK(parse({{"emboss", "none"}})->conversion.emboss.rules.empty());
    CHECK(valueOf(*parse({}), "emboss") == "none");
    CHECK(valueOf(*parse({}), "emboss_detail").is_null());
}

TEST_CASE("reject: tiles that are none") {
    for (const char* bad : {"bricks", "own", "{}", "[]", "{\"\":\"brick\"}", "{\"a\":\"brick\""})
        checkRefused(parse({{"emboss", bad}}), ErrorCode::invalidOption, "/options/emboss");
    for (const char* bad : {R"("own")",
                            R"("none")",
                            "1",
                            "null",
                            "[]",
                            "{}",
                            R"({"size":4})",
                            R"({"tile":"brick","height":[[1]]})",
                            R"({"tile":"brik"})",
                            R"({"tile":1})",
                            R"({"tile":"brick","size":0.4})",
                            R"({"tile":"brick","size":257})",
                            R"({"tile":"brick","size":"4"})",
                            R"({"tile":"brick","depth":-0.1})",
                            R"({"tile":"brick","depth":1.1})",
                            R"({"tile":"brick","turn":45})",
                            R"({"tile":"brick","turn":360})",
                            R"({"tile":"brick","turn":1e99})",
                            R"({"tile":"brick","colour":1})",
                            R"({"height":[]})",
                            R"({"height":[[]]})",
                            R"({"height":[[0,1],[0]]})",
                            R"({"height":[[1.5]]})",
                            R"({"height":[["0"]]})",
                            R"({"height":[0,1]})"})
        checkRefused(parse({{"emboss", std::string("{\"a\":") + bad + "}"}}),
                     ErrorCode::invalidOption, "/options/emboss/a");
    std::string wide = "[0";
    for (int i = 0; i < 64; ++i) wide += ",0";
    wide += "]";
    checkRefused(parse({{"emboss", "{\"a\":{\"height\":[" + wide + "]}}"}}),
                 ErrorCode::invalidOption, "/options/emboss/a");
    std::string tall = "[[0]";
    for (int i = 0; i < 64; ++i) tall += ",[0]";
    tall += "]";
    checkRefused(parse({{"emboss", "{\"a\":{\"height\":" + tall + "}}"}}), ErrorCode::invalidOption,
                 "/options/emboss/a");
    for (const char* bad : {"1", "9", "2.5", "many"})
        checkRefused(parse({{"emboss", "brick"}, {"emboss_detail", bad}}), ErrorCode::invalidOption,
                     "/options/emboss_detail");
}

TEST_CASE("reject: how relief is made, without relief") {
    checkRefused(parse({{"emboss_detail", "4"}}), ErrorCode::invalidOption,
                 "/options/emboss_detail");
    checkRefused(parse({{"emboss", "none"}, {"emboss_method", "displace"}}),
                 ErrorCode::invalidOption, "/options/emboss_method");
}

TEST_CASE("parseOptions: a scale as text and as JSON, made as small as it goes") {
    const auto scaled = [](const std::string& scale) {
        const auto options = parse({{"output", "vox"}, {"scale", scale}});
        REQUIRE(options);
        return options->conversion.output.scale;
    };
    CHECK(scaled("3") == core::Scale{3, 1});
    CHECK(scaled("1/2") == core::Scale{1, 2});
    CHECK(scaled("10/15") == core::Scale{2, 3});
    CHECK(scaled("16/1") == core::Scale{16, 1});
    CHECK(scaled("500/1000") == core::Scale{1, 2});
    for (const char* json :
         {R"({"output":"nrrd","scale":"2/3"})", R"({"output":"nrrd","scale":4})"})
        CHECK(parse({}, json));
    CHECK(valueOf(*parse({{"output", "vox"}, {"scale", "6/2"}}), "scale") == 3);
    CHECK(valueOf(*parse({{"output", "vox"}, {"scale", "2/6"}}), "scale") == "1/3");
}

TEST_CASE("reject: scales that are none, or out of range") {
    for (const char* bad :
         {"0",     "-1", "1/0", "0/1", "0/0",  "1e9", "17",  "1/17", "7/1000000007",
          "1/2/3", "/",  "1/",  "/2",  "1/-2", "+2",  "2.0", "0.5",  "99999999999999999999",
          "1 /2",  "2/", "NaN"}) {
        CAPTURE(bad);
        checkRefused(parse({{"output", "vox"}, {"scale", bad}}), ErrorCode::invalidOption,
                     "/options/scale");
    }
    for (const char* bad : {"0", "-3", "17", "0.5", "1e9", "true", "[1,2]", "{}", "2.0",
                            "18446744073709551615", "-9223372036854775808"}) {
        CAPTURE(bad);
        checkRefused(parse({}, std::string(R"({"output":"vox","scale":)") + bad + "}"),
                     ErrorCode::invalidOption, "/options/scale");
    }
}

TEST_CASE("reject: options of meshes beside voxels, and a scale beside a mesh") {
    checkRefused(parse({{"scale", "2"}}), ErrorCode::invalidOption, "/options/scale");
    checkRefused(parse({{"scale", "1"}, {"output", "obj"}}), ErrorCode::invalidOption,
                 "/options/scale");
    for (const char* output : {"vox", "nrrd"})
        for (const auto& [name, value] : {std::pair("parts", "exterior"),
                                          {"colors", "voxel"},
                                          {"shading", "flat"},
                                          {"up", "y"},
                                          {"compression", "draco"},
                                          {"draco_speed", "5"}})
            checkRefused(parse({{"output", output}, {name, value}}), ErrorCode::invalidOption,
                         std::string("/options/") + name);
    for (const auto& [name, value] : {std::pair("voxel_size", "0.2"), {"pivot", "corner"}}) {
        CHECK(parse({{"output", "nrrd"}, {name, value}}));
        checkRefused(parse({{"output", "vox"}, {name, value}}), ErrorCode::invalidOption,
                     std::string("/options/") + name);
    }
    CHECK(parse({{"output", "nrrd"}, {"compression", "none"}}));
}

TEST_SUITE_END();
