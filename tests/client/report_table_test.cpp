#include "client/report_table.h"

#include <doctest/doctest.h>

#include "client/failure.h"
#include "client/option_help.h"
#include "proto/options.h"

namespace rivage::client {
namespace {

using proto::Json;

void checkHas(const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK_MESSAGE(text.find(part) != std::string::npos, part);
}

}  // namespace

TEST_SUITE_BEGIN("client");

TEST_CASE("report table: the facts of a report") {
    const Json report = Json::parse(R"({
        "input":{"format":"vox 200","dims":[64,68,40],"voxels":1234567,"models":1,"materials":3,
                 "labels":[{"name":"sea","voxels":1000},{"name":"island","voxels":2}]},
        "surface":{"pointels":10,"surfels":20,"junction_linels":5,"interfaces":[{},{},{}]},
        "energy":{"before":{"data":0,"alignment":12.5,"fairness":3,"total":15.5},
                  "after":{"data":1,"alignment":2,"fairness":0.25,"total":3.25}},
        "solver":{"name":"projected","iterations":41,"relative_residual":1e-7},
        "displacement":{"rms":0.125,"max":0.49},"inverted_faces":{"before":4,"after":0},
        "closed":{"sea":true,"island":false},
        "output":{"media_type":"model/gltf-binary","parts":2,"vertices":30,"triangles":40,
                  "bytes":93100},
        "milliseconds":{"parse":1.25,"total":9},"warnings":["one thing"]})");
    const std::string text = reportTable(report);
    for (const char* part :
         {"vox 200, 64 x 68 x 40, 1,234,567 voxels, 1 model, 3 materials",
          "sea 1,000, island 2 (open)", "3 interface(s), 5 junction edges", "12.5",
          "projected, 41 iterations", "1.0e-07", "0.125 rms, 0.49 max", "4 faces before, 0 after",
          "93.1 kB", "parse 1.2, total 9.0 ms", "one thing"})
        checkHas(text, part);
}

TEST_CASE("report table: a report of another server that lacks members is shown all the same") {
    CHECK_FALSE(reportTable(Json::object()).empty());
    CHECK_FALSE(inspectionTable(Json::object()).empty());
    CHECK(optionTable(Json::object()).empty());
}

TEST_CASE("report table: every option with its range and default") {
    const std::string text = optionTable(proto::describeOptions());
    checkHas(text, "--draco-speed          0..10; default 5");
    checkHas(text, "--displacement-limit   none, 0.001..16");
    checkHas(text, "--untangle             true, false; default true");
}

TEST_CASE("option help: an option, all presets, one preset") {
    const Json answer = proto::describeOptions();
    for (const char* name : {"draco_speed", "draco-speed", "--draco-speed"}) {
        const auto help = explainOption(answer, name);
        REQUIRE(help);
        checkHas(help->text, "--draco-speed          0..10; default 5");
        CHECK(help->text.find("--alpha") == std::string::npos);
        CHECK(help->json["name"] == "draco_speed");
    }
    const auto presets = explainOption(answer, "preset");
    REQUIRE(presets);
    // Each that there is has its sentence.
    for (const Json& name : presets->json["values"]) {
        const std::string start = "\n  " + name.get<std::string>() + " ";
        checkHas(presets->text, start);
        const std::size_t at = presets->text.find(start) + start.size();
        CHECK(presets->text.substr(at, presets->text.find('\n', at) - at).ends_with("."));
    }
    const auto noisy = explainOption(answer, "noisy");
    REQUIRE(noisy);
    checkHas(noisy->text, "--displacement-limit   1.5");
    CHECK(noisy->json["options"]["displacement_limit"] == 1.5);
    const auto none = explainOption(answer, "alhpa");
    REQUIRE_FALSE(none);
    CHECK(none.error().exit == ExitCode::usage);
    checkHas(describe(none.error()), "did you mean alpha?");
    CHECK_FALSE(explainOption(Json::object(), "alpha"));
}

TEST_SUITE_END();

}  // namespace rivage::client
