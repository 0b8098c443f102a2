#include "proto/options.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "proto/option_table.h"

using namespace rivage;
using core::ErrorCode;
using proto::JobOptions;
using proto::Json;
using proto::OptionInfo;
using proto::OptionText;
using proto::OptionType;

namespace {

core::Result<JobOptions> parse(const std::vector<OptionText>& text, const std::string& json = {}) {
    return proto::parseOptions(text, json);
}

/// What an option needs beside it to be accepted at all.
std::vector<OptionText> beside(const std::string& name) {
    if (name == "type") return {{"format", "raw"}, {"dims", "1x1x1"}};
    if (name == "dims") return {{"format", "raw"}};
    if (name.starts_with("emboss_")) return {{"emboss", "brick"}};
    if (name.starts_with("smoothing_")) return {{"normals", "piecewise-smooth"}};
    return {};
}

core::Result<JobOptions> parseOne(const std::string& name, const std::string& value) {
    std::vector<OptionText> text = beside(name);
    if (name == "format" && value == "raw") text.push_back({"dims", "1x1x1"});
    text.push_back({name, value});
    return parse(text);
}

core::Result<JobOptions> parseOneJson(const std::string& name, const Json& value) {
    std::vector<OptionText> text = beside(name);
    if (name == "format" && value == "raw") text.push_back({"dims", "1x1x1"});
    return parse(text, proto::writeJson(Json{{name, value}}));
}

void checkRefused(const core::Result<JobOptions>& options, ErrorCode code,
                  const std::string& field) {
    REQUIRE_FALSE(options);
    CHECK(options.error().code == code);
    CHECK(options.error().field == field);
    CHECK_FALSE(options.error().message.empty());
}

std::string text(double value) { return Json(value).dump(); }

Json valueOf(const JobOptions& options, const std::string& name) {
    const Json json = proto::toJson(options);
    return json.contains(name) ? json[name] : Json();
}

}  // namespace

TEST_SUITE_BEGIN("proto");

TEST_CASE("parseOptions: nothing given is the preset studio") {
    const auto options = parse({});
    REQUIRE(options);
    CHECK(options->conversion.method.energy.alpha == 0.01);
    CHECK(options->conversion.method.solve.displacementLimit == 0.49);
    CHECK(options->conversion.output.voxelSize == 0.1);
    CHECK_FALSE(options->run.deadlineMs);
}

TEST_CASE("parseOptions: every word of every option, as text and as JSON") {
    for (const OptionInfo& info : proto::optionInfos()) {
        for (const std::string& word : info.words) {
            CAPTURE(info.name);
            CAPTURE(word);
            const auto fromText = parseOne(info.name, word);
            REQUIRE(fromText);
            const auto fromJson = parseOneJson(info.name, word);
            REQUIRE(fromJson);
            CHECK(proto::toJson(*fromText) == proto::toJson(*fromJson));
            CHECK(valueOf(*fromText, info.name) == word);
        }
    }
}

TEST_CASE("parseOptions: minimum and maximum are taken, just outside is refused") {
    for (const OptionInfo& info : proto::optionInfos()) {
        if (info.type != OptionType::number && info.type != OptionType::integer) continue;
        CAPTURE(info.name);
        for (const double value : {info.minimum, info.maximum}) {
            const auto options = parseOne(info.name, text(value));
            REQUIRE(options);
            CHECK(valueOf(*options, info.name).get<double>() == value);
            CHECK(parseOneJson(info.name, value));
        }
        const bool whole = info.type == OptionType::integer;
        const double below = whole ? info.minimum - 1 : std::nextafter(info.minimum, -1e300);
        const double above = whole ? info.maximum + 1 : std::nextafter(info.maximum, 1e300);
        for (const double value : {below, above}) {
            const std::string field = "/options/" + info.name;
            checkRefused(parseOne(info.name, text(value)), ErrorCode::invalidOption, field);
            checkRefused(parseOneJson(info.name, value), ErrorCode::invalidOption, field);
        }
        if (whole)
            checkRefused(parseOne(info.name, text(info.minimum + 0.5)), ErrorCode::invalidOption,
                         "/options/" + info.name);
    }
}

TEST_CASE("reject: values that are no values, for every option") {
    for (const OptionInfo& info : proto::optionInfos())
        for (const char* value : {"", " ", "nan", "inf", "-inf", "1e999", "0x10", "1,5", "1 ",
                                  "true ", "\xff\xfe", "1x2", "{", "[]", "Draco"}) {
            CAPTURE(info.name);
            CAPTURE(value);
            const auto options = parse({{info.name, value}});
            checkRefused(options, ErrorCode::invalidOption, "/options/" + info.name);
        }
}

TEST_CASE("reject: JSON values of the wrong type, for every option") {
    for (const OptionInfo& info : proto::optionInfos()) {
        CAPTURE(info.name);
        for (const char* value : {"null", "[]", "[[]]", "\"0.1\"", "\"true\"", "-1e300"}) {
            CAPTURE(value);
            checkRefused(parse({}, "{\"" + info.name + "\":" + value + "}"),
                         ErrorCode::invalidOption, "/options/" + info.name);
        }
    }
}

TEST_CASE("reject: the message names the option, what is allowed and what was given") {
    const auto options = parse({{"radius", "99"}});
    REQUIRE_FALSE(options);
    CHECK(options.error().message == "radius must be a number from 0.5 to 32, or auto, not \"99\"");
    const auto word = parse({{"fairness", "guided"}});
    REQUIRE_FALSE(word);
    CHECK(word.error().message == "fairness must be umbrella or tangential, not \"guided\"");
    const auto near = parse({{"compression", "darco"}});
    REQUIRE_FALSE(near);
    CHECK(near.error().message.ends_with("did you mean draco?"));
}

TEST_CASE("reject: an unknown option, with a suggestion where one is near") {
    const auto typo = parse({{"alhpa", "1"}});
    checkRefused(typo, ErrorCode::unknownOption, "/options/alhpa");
    CHECK(typo.error().message.ends_with("did you mean alpha?"));
    const auto far = parse({{"wibble", "1"}});
    checkRefused(far, ErrorCode::unknownOption, "/options/wibble");
    CHECK(far.error().message == "there is no option \"wibble\"");
    checkRefused(parse({}, R"({"lods":"1"})"), ErrorCode::unknownOption, "/options/lods");
    checkRefused(parse({{"a/b\n", "1"}}), ErrorCode::unknownOption, "/options");
}

TEST_CASE("reject: the same option twice, in one part or across both") {
    checkRefused(parse({{"alpha", "1"}, {"alpha", "1"}}), ErrorCode::invalidOption,
                 "/options/alpha");
    checkRefused(parse({{"alpha", "1"}}, R"({"alpha":1})"), ErrorCode::invalidOption,
                 "/options/alpha");
    checkRefused(parse({}, R"({"alpha":1,"alpha":1})"), ErrorCode::malformedRequest, "/options");
}

TEST_CASE("reject: JSON that is no object, too deep, or not finite") {
    for (const char* json : {"[]", "1", "\"x\"", "{\"alpha\":NaN}", "{\"alpha\":1e999}", "{"})
        checkRefused(parse({}, json), ErrorCode::malformedRequest, "/options");
    checkRefused(parse({}, std::string(200000, '[')), ErrorCode::malformedRequest, "/options");
}

TEST_CASE("parseOptions: the preset comes first, what is given beside it wins in any order") {
    const auto before = parse({{"alpha", "0.5"}, {"preset", "paper"}});
    const auto after = parse({{"preset", "paper"}, {"alpha", "0.5"}});
    REQUIRE(before);
    REQUIRE(after);
    CHECK(proto::toJson(*before) == proto::toJson(*after));
    CHECK(before->conversion.method.energy.alpha == 0.5);
    CHECK(before->conversion.method.energy.fairness == core::Fairness::umbrella);
    CHECK_FALSE(before->conversion.method.solve.displacementLimit);
    const auto split = parse({{"alpha", "0.5"}}, R"({"preset":"paper"})");
    REQUIRE(split);
    CHECK(proto::toJson(*split) == proto::toJson(*before));
}

TEST_CASE("parseOptions: every preset sets what it stands for") {
    const auto noisy = parse({{"preset", "noisy"}});
    REQUIRE(noisy);
    CHECK(noisy->conversion.method.normals.method == core::NormalMethod::robust);
    CHECK(noisy->conversion.method.solve.displacementLimit == 1.5);
    checkRefused(parse({{"preset", "noisy"}, {"radius", "4"}}), ErrorCode::invalidOption,
                 "/options/radius");
    const auto architectural = parse({{"preset", "architectural"}});
    REQUIRE(architectural);
    CHECK(architectural->conversion.method.energy.alpha == 0.05);
}

TEST_CASE("parseOptions: dims as text and as JSON") {
    const auto fromText = parse({{"format", "raw"}, {"dims", "64x68x40"}});
    REQUIRE(fromText);
    CHECK(*fromText->conversion.input.dims == core::Vec3i(64, 68, 40));
    CHECK(parse({{"format", "raw"}}, R"({"dims":[64,68,40]})"));
    CHECK(parse({{"format", "raw"}}, R"({"dims":"64x68x40"})"));
    for (const char* bad : {"0x1x1", "1x1", "1x1x1x1", "1x1x65537", "-1x1x1", "1 x1x1", "axbxc",
                            "99999999999x1x1", "x", "1x1x"})
        checkRefused(parse({{"format", "raw"}, {"dims", bad}}), ErrorCode::invalidOption,
                     "/options/dims");
    for (const char* bad : {"[1,1]", "[1,1,1.5]", "[1,1,0]", "[1,1,\"1\"]"})
        checkRefused(parse({{"format", "raw"}}, std::string("{\"dims\":") + bad + "}"),
                     ErrorCode::invalidOption, "/options/dims");
}

TEST_CASE("parseOptions: spacing as text and as JSON") {
    const auto fromText = parse({{"spacing", "1x1x2.5"}});
    REQUIRE(fromText);
    CHECK(fromText->conversion.input.spacing == core::Vec3d(1, 1, 2.5));
    CHECK(valueOf(*fromText, "spacing") == Json::array({1, 1, 2.5}));
    const auto fromJson = parse({}, R"({"spacing":[1,1,2.5]})");
    REQUIRE(fromJson);
    CHECK(proto::toJson(*fromText) == proto::toJson(*fromJson));
    CHECK(parse({}, R"({"spacing":"0.3x0.3x1e-1"})"));
    CHECK(parse({{"spacing", "1x100x1"}}));
    for (const char* bad : {"1x1", "1x1x1x1", "0x1x1", "1x1x-1", "1x1x100.1", "0.009x1x0.5", "x",
                            "1x1x", "axbxc", "1x1xnan", "1x1xinf", "1e7x1e7x1e7", "1 x1x1"})
        checkRefused(parse({{"spacing", bad}}), ErrorCode::invalidOption, "/options/spacing");
    for (const char* bad : {"[1,1]", "[1,1,0]", "[1,1,101]", "[1,1,\"1\"]", "1", "[1,1,null]"})
        checkRefused(parse({}, std::string("{\"spacing\":") + bad + "}"), ErrorCode::invalidOption,
                     "/options/spacing");
}

TEST_CASE("parseOptions: weights by region, as text and as JSON") {
    const std::string map = R"({"sea":{"alpha":10,"beta":0.5},"*":{"gamma":2}})";
    const auto fromText = parse({{"weights", map}, {"preset", "paper"}});
    REQUIRE(fromText);
    const auto& regions = fromText->conversion.method.energy.regions;
    REQUIRE(regions.size() == 2);
    CHECK(regions[0].region == "sea");
    CHECK(regions[0].alpha == 10);
    CHECK(regions[0].beta == 0.5);
    CHECK(regions[0].gamma == 1);
    CHECK(regions[1].region == "*");
    CHECK(regions[1].gamma == 2);
    const auto fromJson = parse({}, R"({"preset":"paper","weights":)" + map + "}");
    REQUIRE(fromJson);
    CHECK(proto::toJson(*fromText) == proto::toJson(*fromJson));
    CHECK(valueOf(*parse({}), "weights").is_null());
}

TEST_CASE("reject: weights that are no factors") {
    for (const char* bad :
         {"{}", R"({"a":{}})", R"({"a":1})", R"({"a":{"delta":1}})", R"({"a":{"alpha":"1"}})",
          R"({"a":{"alpha":0}})", R"({"a":{"alpha":1001}})", R"({"a":{"alpha":1e-4}})",
          R"({"":{"alpha":1}})", R"({"a":{"alpha":1},"a":{"beta":1}})", R"({"a":null})",
          R"({"a":{"alpha":1})", R"({"a":{"alpha":{}}})"})
        checkRefused(parse({{"weights", bad}}), ErrorCode::invalidOption, "/options/weights");
    const std::string longName(65, 'a');
    checkRefused(parse({{"weights", "{\"" + longName + "\":{\"alpha\":1}}"}}),
                 ErrorCode::invalidOption, "/options/weights");
}

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

TEST_CASE("parseOptions: paper does not split umbrellas, unless asked to") {
    CHECK(parse({})->conversion.method.energy.split);
    CHECK_FALSE(parse({{"preset", "paper"}})->conversion.method.energy.split);
    CHECK(parse({{"preset", "paper"}, {"split", "true"}})->conversion.method.energy.split);
}

TEST_CASE("parseOptions: a label map, as text and as JSON") {
    const std::string map = R"({"sea":[12,13],"sand":7,"island":"*"})";
    const auto fromText = parse({{"labels", map}});
    REQUIRE(fromText);
    const core::InputOptions& input = fromText->conversion.input;
    CHECK(input.labels == core::LabelMode::map);
    REQUIRE(input.labelMap.size() == 3);
    CHECK(input.labelMap[0].name == "sea");
    CHECK(input.labelMap[0].values == std::vector<std::uint32_t>{12, 13});
    CHECK(input.labelMap[1].values == std::vector<std::uint32_t>{7});
    CHECK(input.labelMap[2].rest);
    const auto fromJson = parse({}, "{\"labels\":" + map + "}");
    REQUIRE(fromJson);
    CHECK(proto::toJson(*fromText) == proto::toJson(*fromJson));
}

TEST_CASE("reject: label maps that contradict themselves") {
    for (const char* bad :
         {R"({})", R"({"a":[]})", R"({"a":"*","b":"*"})", R"({"a":[-1]})", R"({"a":[1.5]})",
          R"({"a":[4294967296]})", R"({"a":"b"})", R"({"":[1]})", R"({"a":1,"a":2})",
          R"({"a":{"b":1}})", R"({"a":null})", R"({"a":[1)"})
        checkRefused(parse({{"labels", bad}}), ErrorCode::invalidOption, "/options/labels");
    checkRefused(parse({{"labels", R"({"a":[1,2],"b":[2]})"}}), ErrorCode::invalidOption,
                 "/options/labels/b");
}

TEST_CASE("reject: options without effect beside the others") {
    checkRefused(parse({{"dims", "1x1x1"}}), ErrorCode::invalidOption, "/options/dims");
    checkRefused(parse({{"type", "u16"}, {"format", "vox"}}), ErrorCode::invalidOption,
                 "/options/type");
    checkRefused(parse({{"format", "raw"}}), ErrorCode::invalidOption, "/options/dims");
    checkRefused(parse({{"draco_speed", "1"}, {"compression", "none"}}), ErrorCode::invalidOption,
                 "/options/draco_speed");
    checkRefused(parse({{"output", "obj"}, {"compression", "draco"}}), ErrorCode::invalidOption,
                 "/options/compression");
    CHECK(parse({{"output", "obj"}, {"compression", "none"}}));
    CHECK(parse({{"output", "obj"}}));
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
    for (const char* json : {R"({"output":"nrrd","scale":"2/3"})", R"({"output":"nrrd","scale":4})"})
        CHECK(parse({}, json));
    CHECK(valueOf(*parse({{"output", "vox"}, {"scale", "6/2"}}), "scale") == 3);
    CHECK(valueOf(*parse({{"output", "vox"}, {"scale", "2/6"}}), "scale") == "1/3");
}

TEST_CASE("reject: scales that are none, or out of range") {
    for (const char* bad :
         {"0", "-1", "1/0", "0/1", "0/0", "1e9", "17", "1/17", "7/1000000007", "1/2/3", "/", "1/",
          "/2", "1/-2", "+2", "2.0", "0.5", "99999999999999999999", "1 /2", "2/", "NaN"}) {
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
        for (const auto& [name, value] : {std::pair("parts", "exterior"), {"colors", "voxel"},
                                          {"shading", "flat"}, {"up", "y"},
                                          {"compression", "draco"}, {"draco_speed", "5"}})
            checkRefused(parse({{"output", output}, {name, value}}), ErrorCode::invalidOption,
                         std::string("/options/") + name);
    for (const auto& [name, value] : {std::pair("voxel_size", "0.2"), {"pivot", "corner"}}) {
        CHECK(parse({{"output", "nrrd"}, {name, value}}));
        checkRefused(parse({{"output", "vox"}, {name, value}}), ErrorCode::invalidOption,
                     std::string("/options/") + name);
    }
    CHECK(parse({{"output", "nrrd"}, {"compression", "none"}}));
}

TEST_CASE("property: the effective options, given back, are the same options") {
    const std::vector<std::vector<OptionText>> cases{
        {},
        {{"preset", "paper"}},
        {{"format", "raw"}, {"dims", "3x4x5"}, {"type", "u16"}},
        {{"labels", R"({"sea":[12,13],"island":"*"})"}, {"output", "obj"}},
        {{"displacement_limit", "none"}, {"draco_position_bits", "12"}, {"alpha", "1e-7"}},
        {{"border", "open"}, {"spacing", "0.5x1x2"}, {"split", "false"}},
        {{"output", "vox"}, {"scale", "3/2"}},
        {{"output", "nrrd"}, {"scale", "1/2"}, {"compression", "none"}, {"pivot", "world"}},
        {{"weights", R"({"sea":{"alpha":10},"*":{"gamma":2}})"}},
        {{"emboss", "brick"}, {"emboss_method", "displace"}},
        {{"emboss", R"({"*":{"height":[[0,1]],"size":2,"turn":90},"a":"cobble"})"}},
        {{"hidden", "keep"},
         {"untangle", "false"},
         {"deadline_ms", "1000"},
         {"progressive", "true"}}};
    for (const auto& given : cases) {
        const auto options = parse(given);
        REQUIRE(options);
        const Json echo = proto::toJson(*options);
        const auto again = parse({}, proto::writeJson(echo));
        REQUIRE(again);
        CHECK(proto::toJson(*again) == echo);
    }
    CHECK_FALSE(proto::toJson(parse({{"deadline_ms", "9"}})->conversion).contains("deadline_ms"));
}

TEST_CASE("parseOptions: progressive changes how a job runs, not what it converts") {
    const auto options = parse({{"progressive", "true"}});
    REQUIRE(options);
    CHECK(options->run.progressive);
    CHECK(proto::toJson(*options)["progressive"] == true);
    CHECK(proto::toJson(options->conversion) == proto::toJson(parse({})->conversion));
    CHECK_FALSE(parse({})->run.progressive);
    CHECK_FALSE(proto::toJson(*parse({})).contains("progressive"));
    CHECK_FALSE(parse({{"progressive", "perhaps"}}));
}

TEST_CASE("describeOptions: every option with type, default and a sentence") {
    const Json list = proto::describeOptions()["options"];
    CHECK(list.size() == proto::optionInfos().size());
    for (const Json& option : list) {
        CAPTURE(option["name"].get<std::string>());
        CHECK(option.contains("default"));
        CHECK(option["description"].get<std::string>().ends_with("."));
        if (option["type"] == "choice") CHECK(option["values"].size() >= 2);
        if (option["type"] == "number") CHECK(option["minimum"] < option["maximum"]);
        if (option["name"] == "alpha") {
            CHECK(option["default"] == 0.01);
            CHECK(option["presets"]["paper"] == 0.001);
        }
    }
}

TEST_CASE("nearestName: one or two slips are forgiven, another word is not") {
    const std::vector<std::string> names{"alpha", "beta", "displacement_limit"};
    CHECK(proto::nearestName("aplha", names) == "alpha");
    CHECK(proto::nearestName("displacment_limt", names) == "displacement_limit");
    CHECK(proto::nearestName("colors", names).empty());
    CHECK(proto::nearestName(std::string(10000, 'a'), names).empty());
}

TEST_SUITE_END();
