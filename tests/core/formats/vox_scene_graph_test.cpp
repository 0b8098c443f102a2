#include "core/formats/vox_scene_graph.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "core/formats/read_vox.h"
#include "tests/support/vox_builder.h"

using namespace rivage::core;
using rivage::test::VoxBuilder;

namespace {

void checkRefused(const VoxBuilder& builder, ErrorCode code, const std::string& field,
                  const Limits& limits = {}) {
    const auto scene = readVox(builder.bytes(), {}, {.limits = limits});
    REQUIRE_FALSE(scene);
    CHECK(scene.error().code == code);
    CHECK(scene.error().field == field);
}

std::vector<Instance> instancesOf(const VoxBuilder& builder, int frame = 0) {
    const auto scene = readVox(builder.bytes(), {.frame = frame}, {});
    REQUIRE(scene);
    return scene->instances;
}

/// A chain of `levels` groups, each of which holds the next one twice; the last holds a shape.
VoxBuilder doublingScene(std::uint32_t levels, bool withShape) {
    VoxBuilder builder;
    builder.cube(1, 1);
    for (std::uint32_t i = 0; i < levels; ++i) builder.group(i, {i + 1, i + 1});
    return withShape ? builder.shape(levels, {0}) : builder.group(levels, {});
}

}  // namespace

TEST_SUITE_BEGIN("core/formats");

TEST_CASE("scene graph: transforms compose as parent times own") {
    // _r 17: row 0 takes column 1 with a minus sign, row 1 column 0: a quarter turn about z.
    const auto instances = instancesOf(VoxBuilder()
                                           .cube(1, 1)
                                           .transform(0, 1, {{"_r", "17"}, {"_t", "10 20 30"}})
                                           .group(1, {2})
                                           .transform(2, 3, {{"_t", "1 2 3"}, {"_r", "100"}})
                                           .shape(3, {0}));
    REQUIRE(instances.size() == 1);
    Mat3i quarter;
    quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    Mat3i mirrored;  // 100 = column 0, column 1, signs of rows 1 and 2
    mirrored << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    CHECK(instances[0].rotation == Mat3i(quarter * mirrored));
    CHECK(instances[0].translation == Vec3i(10 - 2, 20 + 1, 30 + 3));
    CHECK(instances[0].centered);
}

TEST_CASE("scene graph: the rotation of the format text") {
    const auto instances =
        instancesOf(VoxBuilder().cube(1, 1).transform(0, 1, {{"_r", "105"}}).shape(1, {0}));
    Mat3i expected;
    expected << 0, 1, 0, 0, 0, -1, -1, 0, 0;
    CHECK(instances[0].rotation == expected);
}

TEST_CASE("scene graph: order is depth first, names come from the nearest node that has one") {
    const auto instances = instancesOf(VoxBuilder()
                                           .cube(1, 1)
                                           .cube(1, 2)
                                           .cube(1, 3)
                                           .transform(0, 1, {}, {{"_name", "world"}})
                                           .group(1, {5, 2, 9})
                                           .transform(2, 3, {}, {{"_name", "door"}})
                                           .shape(3, {1})
                                           .group(5, {6})
                                           .transform(6, 7)
                                           .shape(7, {2})
                                           .shape(9, {0}));
    REQUIRE(instances.size() == 3);
    CHECK(instances[0].frames == std::vector<int>{2});
    CHECK(instances[1].frames == std::vector<int>{1});
    CHECK(instances[2].frames == std::vector<int>{0});
    CHECK(instances[0].name == "world");
    CHECK(instances[1].name == "door");
}

TEST_CASE("scene graph: hidden nodes, groups and layers hide what is below them") {
    const VoxBuilder::Dict hidden{{"_hidden", "1"}};
    const auto instances = instancesOf(VoxBuilder()
                                           .cube(1, 1)
                                           .transform(0, 1)
                                           .group(1, {2, 4, 6, 8})
                                           .transform(2, 3, {}, hidden)
                                           .shape(3, {0})
                                           .transform(4, 5, {}, {}, 3)
                                           .shape(5, {0})
                                           .group(6, {7}, hidden)
                                           .shape(7, {0})
                                           .transform(8, 9, {}, {{"_hidden", "0"}}, 2)
                                           .shape(9, {0})
                                           .layer(2, {{"_hidden", "0"}})
                                           .layer(3, hidden));
    REQUIRE(instances.size() == 4);
    CHECK(instances[0].hidden);
    CHECK(instances[1].hidden);
    CHECK(instances[1].layer == 3);
    CHECK(instances[2].hidden);
    CHECK_FALSE(instances[3].hidden);
}

TEST_CASE("scene graph: a model that is shown twice gives two instances") {
    const auto instances = instancesOf(VoxBuilder()
                                           .cube(1, 1)
                                           .group(0, {1, 2})
                                           .transform(1, 3, {{"_t", "1 0 0"}})
                                           .transform(2, 3, {{"_t", "2 0 0"}})
                                           .shape(3, {0}));
    REQUIRE(instances.size() == 2);
    CHECK(instances[0].translation == Vec3i(1, 0, 0));
    CHECK(instances[1].translation == Vec3i(2, 0, 0));
}

TEST_CASE("scene graph: keys of transforms and shapes hold until the next one") {
    const std::string node = VoxBuilder::number(0) + VoxBuilder::dict({}) + VoxBuilder::number(1) +
                             VoxBuilder::number(0xffffffff) + VoxBuilder::number(0) +
                             VoxBuilder::number(2) +
                             VoxBuilder::dict({{"_t", "1 1 1"}, {"_f", "0"}}) +
                             VoxBuilder::dict({{"_t", "5 5 5"}, {"_f", "10"}});
    const std::string shape = VoxBuilder::number(1) + VoxBuilder::dict({}) + VoxBuilder::number(2) +
                              VoxBuilder::number(0) + VoxBuilder::dict({{"_f", "0"}}) +
                              VoxBuilder::number(1) + VoxBuilder::dict({{"_f", "7"}});
    const VoxBuilder file =
        VoxBuilder().cube(1, 1).cube(1, 2).chunk("nTRN", node).chunk("nSHP", shape);
    CHECK(instancesOf(file, 9)[0].translation == Vec3i(1, 1, 1));
    CHECK(instancesOf(file, 10)[0].translation == Vec3i(5, 5, 5));
    CHECK(instancesOf(file, 99)[0].translation == Vec3i(5, 5, 5));
    CHECK(instancesOf(file)[0].frames == std::vector<int>{0, 1});
    CHECK(instancesOf(file)[0].frameTimes == std::vector<int>{0, 7});
}

TEST_CASE("reject: a cyclic scene graph") {
    checkRefused(VoxBuilder().cube(1, 1).transform(0, 1).group(1, {2}).transform(2, 1),
                 ErrorCode::malformedInput, "/grid/nodes/1");
    checkRefused(VoxBuilder().cube(1, 1).transform(0, 0), ErrorCode::malformedInput,
                 "/grid/nodes/0");
    checkRefused(VoxBuilder().cube(1, 1).shape(0, {0}).group(4, {5}).group(5, {4}),
                 ErrorCode::malformedInput, "/grid/nodes/4");
}

TEST_CASE("reject: missing nodes, missing models, ids used twice, no root") {
    checkRefused(VoxBuilder().cube(1, 1).transform(0, 7), ErrorCode::malformedInput,
                 "/grid/nodes/0");
    checkRefused(VoxBuilder().cube(1, 1).transform(0, 1).shape(1, {1}), ErrorCode::malformedInput,
                 "/grid/nodes/1");
    checkRefused(VoxBuilder().cube(1, 1).transform(0, 1).shape(1, {0}).shape(1, {0}),
                 ErrorCode::malformedInput, "/grid/nodes/1");
    checkRefused(VoxBuilder().cube(1, 1).shape(1, {0}), ErrorCode::malformedInput, "/grid/nodes/0");
    checkRefused(VoxBuilder().cube(1, 1).shape(0, {}), ErrorCode::malformedInput, "/grid/nodes/0");
}

TEST_CASE("reject: rotations and translations that are none") {
    for (const char* rotation : {"0", "5", "3", "15", "128", "-4", "4x", " "}) {
        CAPTURE(rotation);
        checkRefused(VoxBuilder().cube(1, 1).transform(0, 1, {{"_r", rotation}}).shape(1, {0}),
                     ErrorCode::malformedInput, "/grid/nodes/0/_r");
    }
    for (const char* translation : {"1 2", "1 2 3 4", "1 2 3x", "1e3 0 0", "9999999999 0 0"}) {
        CAPTURE(translation);
        checkRefused(VoxBuilder().cube(1, 1).transform(0, 1, {{"_t", translation}}).shape(1, {0}),
                     ErrorCode::malformedInput, "/grid/nodes/0/_t");
    }
    checkRefused(VoxBuilder()
                     .cube(1, 1)
                     .transform(0, 1, {{"_t", "2147483647 0 0"}})
                     .transform(1, 2, {{"_t", "2147483647 0 0"}})
                     .shape(2, {0}),
                 ErrorCode::malformedInput, "/grid/nodes/0");
}

TEST_CASE("scene graph: a very deep chain needs no stack") {
    VoxBuilder builder;
    builder.cube(1, 1);
    constexpr std::uint32_t kDepth = 50000;
    for (std::uint32_t i = 0; i < kDepth; ++i) builder.group(i, {i + 1});
    CHECK(instancesOf(builder.shape(kDepth, {0})).size() == 1);
}

TEST_CASE("reject: shared groups that unfold exponentially, with and without shapes") {
    CHECK(instancesOf(doublingScene(6, true)).size() == 64);
    checkRefused(doublingScene(60, true), ErrorCode::tooLarge, "/grid/nodes");
    checkRefused(doublingScene(60, false), ErrorCode::tooLarge, "/grid/nodes");
    checkRefused(doublingScene(6, true), ErrorCode::tooLarge, "/grid/nodes", {.maxModels = 63});
    CHECK(readVox(doublingScene(6, true).bytes(), {}, {.limits = {.maxModels = 64}}));
}

TEST_CASE("reject: more nodes than the limit") {
    checkRefused(
        VoxBuilder().cube(1, 1).group(0, {}).group(1, {}).group(2, {}).group(3, {}).group(4, {}),
        ErrorCode::tooLarge, "/grid/nodes", {.maxModels = 1});
}

TEST_SUITE_END();
