#include "core/grid/label_assignment.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace rivage::core;

namespace {

using Names = std::vector<std::string>;

/// Two plain materials, one of every other class, and one that no voxel uses.
struct Table {
    IdVector<MaterialId, Material> materials{1};
    std::vector<bool> used{false};

    Table() {
        for (const MaterialClass kind :
             {MaterialClass::cloud, MaterialClass::opaque, MaterialClass::glass,
              MaterialClass::metal, MaterialClass::emissive, MaterialClass::opaque}) {
            materials.push_back(
                {.source = static_cast<std::uint32_t>(20 - materials.size()), .kind = kind});
            used.push_back(true);
        }
        materials.push_back({.source = 99});
        used.push_back(false);
    }
    Result<IdVector<Label, std::string>> assign(const InputOptions& options,
                                                GridFormat format = GridFormat::vox,
                                                const Limits& limits = {}) {
        return assignLabels(materials, used, format, options, limits);
    }
    [[nodiscard]] std::vector<int> labels() const {
        std::vector<int> all;
        for (std::size_t i = 1; i < materials.size(); ++i)
            all.push_back(index(materials.raw()[i].label));
        return all;
    }
};

Error mapError(const std::vector<LabelRule>& rules) {
    Table table;
    const auto labels = table.assign({.labels = LabelMode::map, .labelMap = rules});
    REQUIRE_FALSE(labels);
    return labels.error();
}

}  // namespace

TEST_SUITE_BEGIN("core/grid");

TEST_CASE("labels: auto parts a .vox scene into opaque, glass and cloud") {
    Table table;
    const auto names = table.assign({});
    REQUIRE(names);
    CHECK(names->raw() == Names{"", "opaque", "glass", "cloud"});
    CHECK(table.labels() == std::vector<int>{3, 1, 2, 1, 1, 1, 0});
}

TEST_CASE("labels: auto gives other formats one label a value") {
    Table table;
    const auto names = table.assign({}, GridFormat::npy);
    REQUIRE(names);
    CHECK(names->raw() == Names{"", "14", "15", "16", "17", "18", "19"});
    CHECK(table.labels() == std::vector<int>{6, 5, 4, 3, 2, 1, 0});
}

TEST_CASE("labels: values of a volume that have a name bring it along, each its own") {
    Table table;
    for (const std::size_t m : {1U, 3U, 4U}) table.materials.raw()[m].name = "lung";
    table.materials.raw()[2].name = "heart";
    CHECK(table.assign({}, GridFormat::nrrd)->raw() ==
          Names{"", "14", "15", "lung", "lung 17", "heart", "lung 19"});
    CHECK(table.assign({.labels = LabelMode::palette}, GridFormat::vox)->raw() ==
          Names{"", "14", "15", "16", "17", "18", "19"});
}

TEST_CASE("labels: solid, material and palette") {
    Table table;
    CHECK(table.assign({.labels = LabelMode::solid})->raw() == Names{"", "solid"});
    CHECK(table.labels() == std::vector<int>{1, 1, 1, 1, 1, 1, 0});
    CHECK(table.assign({.labels = LabelMode::material})->raw() ==
          Names{"", "opaque", "metal", "glass", "emissive", "cloud"});
    CHECK(table.labels() == std::vector<int>{5, 1, 3, 2, 4, 1, 0});
    CHECK(table.assign({.labels = LabelMode::palette})->raw() ==
          Names{"", "14", "15", "16", "17", "18", "19"});
}

TEST_CASE("labels: a map, in its own order, with a rest; labels without a voxel do not exist") {
    Table table;
    const std::vector<LabelRule> rules{
        {"roof", {16, 14}}, {"none", {99}}, {"walls", {19}}, {"other", {}, true}};
    const auto names = table.assign({.labels = LabelMode::map, .labelMap = rules});
    REQUIRE(names);
    CHECK(names->raw() == Names{"", "roof", "walls", "other"});
    CHECK(table.labels() == std::vector<int>{2, 3, 3, 1, 3, 1, 0});
}

TEST_CASE("labels: values that no rule takes are background") {
    Table table;
    const auto names = table.assign({.labels = LabelMode::map, .labelMap = {{"one", {18}}}});
    REQUIRE(names);
    CHECK(table.labels() == std::vector<int>{0, 1, 0, 0, 0, 0, 0});
}

TEST_CASE("reject: label maps that contradict themselves") {
    for (const auto& rules : std::vector<std::vector<LabelRule>>{{},
                                                                 {{"a", {1, 2}}, {"b", {2}}},
                                                                 {{"a", {1, 1}}},
                                                                 {{"a", {}, true}, {"b", {}, true}},
                                                                 {{"a", {1}}, {"a", {2}}},
                                                                 {{"a", {0}}},
                                                                 {{"", {1}}}}) {
        const Error error = mapError(rules);
        CHECK(error.code == ErrorCode::invalidOption);
        CHECK(error.field == "/options/labels");
    }
    CHECK(mapError({{"sea", {1, 2}}, {"land", {2}}}).message.find("'sea' and 'land'") !=
          std::string::npos);
}

TEST_CASE("reject: more labels than the limit, and the limit itself") {
    Table table;
    CHECK(table.assign({.labels = LabelMode::palette}, GridFormat::vox, {.maxLabels = 6}));
    const auto labels =
        table.assign({.labels = LabelMode::palette}, GridFormat::vox, {.maxLabels = 5});
    REQUIRE_FALSE(labels);
    CHECK(labels.error().code == ErrorCode::tooManyLabels);
    CHECK(labels.error().limit == 5);
    CHECK(labels.error().actual == 6);
}

TEST_SUITE_END();
