#include "proto/options.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "proto/option_table.h"
#include "tests/proto/option_checks.h"

using namespace rivage;
using core::ErrorCode;
using proto::JobOptions;
using proto::Json;
using proto::OptionInfo;
using proto::OptionText;
using proto::OptionType;
using namespace rivage::test;

namespace {

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

std::string text(double value) { return Json(value).dump(); }

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
    CHECK(valueOf(*parse({}), "spacing") == "auto");
    CHECK(parse({})->conversion.input.spacing == std::nullopt);
    CHECK(parse({{"spacing", "auto"}})->conversion.input.spacing == std::nullopt);
    CHECK(parse({}, R"({"spacing":"auto"})"));
    CHECK(parse({{"spacing", "1x1x1"}})->conversion.input.spacing == core::Vec3d(1, 1, 1));
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
