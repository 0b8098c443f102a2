#include "client/compare/compare.h"

#include <doctest/doctest.h>

#include <ctime>

#include "glb_builder.h"

using namespace rivage::client;
using namespace rivage::client::test;
using Eigen::Vector3f;
using rivage::proto::Json;

namespace {

Json reportOf(double alpha, double energy) {
    return {
        {"input", {{"dims", {4, 4, 4}}, {"voxels", 8}}},
        {"options", {{"alpha", alpha}, {"voxel_size", 0.5}, {"up", "y"}}},
        {"energy",
         {{"before", {{"data", 0}, {"total", 10}}}, {"after", {{"data", 1}, {"total", energy}}}}}};
}

Json compared(const std::vector<Shape>& a, const std::vector<Shape>& b,
              CompareSettings settings = {}) {
    const auto json = compareAssets(plainGlb(a, reportOf(0.1, 5)).bytes(),
                                    plainGlb(b, reportOf(0.2, 4)).bytes(), settings);
    REQUIRE(json);
    return *json;
}

std::string kindOf(const Json& json) { return json["verdict"]["kind"]; }

double maxVoxels(const Json& json) { return json["distance"]["max"]["voxels"]; }

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("client/compare") {
    TEST_CASE("compareAssets: the same file") {
        const std::string bytes = plainGlb({cube(0, 1)}).bytes();
        const auto json = compareAssets(bytes, bytes);
        REQUIRE(json);
        CHECK(kindOf(*json) == "same_bytes");
        CHECK((*json)["distance"]["max"]["meters"] == 0);
        CHECK(comparisonTable(*json).ends_with("\nsame bytes\n"));
        CHECK(exitOf(*json) == ExitCode::ok);
    }

    TEST_CASE("regression: rounding was a distance, and made --max-distance 0 fail on one file") {
        const std::string bytes = plainGlb({ball({0.3F, 0.7F, -0.1F}, 1.7F, 24)}).bytes();
        const auto json = compareAssets(bytes, bytes, {.voxelSize = 0.1, .maxDistance = 0});
        REQUIRE(json);
        CHECK((*json)["distance"]["max"]["meters"] == 0);
        CHECK((*json)["distance"]["a_to_b"]["meters"]["max_at_most"] == 0);
        CHECK(exitOf(*json) == ExitCode::ok);
    }

    TEST_CASE("compareAssets: distances in metres and in voxels of the report") {
        const Json json = compared({plane(4, 4, 0)}, {plane(4, 4, 0.25F)});
        CHECK(kindOf(json) == "different");
        CHECK(json["voxel_size"] == 0.5);
        for (const char* way : {"a_to_b", "b_to_a"})
            for (const char* figure : {"mean", "rms", "p95", "p99", "max"}) {
                CAPTURE(figure);
                CHECK(json["distance"][way]["meters"][figure].get<double>() ==
                      doctest::Approx(0.25));
                CHECK(json["distance"][way]["voxels"][figure].get<double>() ==
                      doctest::Approx(0.5));
            }
        CHECK(maxVoxels(json) == doctest::Approx(0.5));
        CHECK(json["normals"]["mean_degrees"] == 0);
        CHECK(json["colors"].is_null());
    }

    TEST_CASE("compareAssets: the two directions are not the same") {
        // All of the small square lies on the large one, whose far corner is sqrt(2) away.
        const Json json = compared({plane(1, 2, 0)}, {plane(2, 2, 0)});
        CHECK(json["distance"]["a_to_b"]["meters"]["max"] == 0);
        CHECK(json["distance"]["b_to_a"]["meters"]["max"].get<double>() ==
              doctest::Approx(std::sqrt(2)));
        CHECK(json["distance"]["b_to_a"]["at"] == Json({2.0, 2.0, 0.0}));
    }

    TEST_CASE("compareAssets: energies and the options that differ come from the reports") {
        const Json json = compared({cube(0, 1)}, {cube(0, 1)});
        CHECK(json["energy"]["a"]["after"]["total"] == 5);
        CHECK(json["energy"]["b"]["after"]["total"] == 4);
        REQUIRE(json["options"].size() == 1);
        CHECK(json["options"][0] == Json({{"name", "alpha"}, {"a", 0.1}, {"b", 0.2}}));
        CHECK(json["notes"].empty());
    }

    TEST_CASE("compareAssets: other grids and places are said") {
        Json other = reportOf(0.1, 5);
        other["options"]["up"] = "z";
        other["input"]["voxels"] = 9;
        const auto json = compareAssets(plainGlb({cube(0, 1)}, reportOf(0.1, 5)).bytes(),
                                        plainGlb({cube(0, 1)}, other).bytes());
        REQUIRE(json);
        CHECK((*json)["notes"].size() == 2);
        CHECK(has(comparisonTable(*json), "up differs"));
    }

    TEST_CASE("compareAssets: the same surface in other bytes, by Draco and by OBJ") {
        const std::vector<Shape> shapes{ball({0, 0, 0}, 1, 9)};
        Shape clean = shapes[0];
        std::erase_if(clean.triangles, [&](const auto& t) {
            return clean.positions[t[0]] == clean.positions[t[1]] ||
                   clean.positions[t[1]] == clean.positions[t[2]] ||
                   clean.positions[t[2]] == clean.positions[t[0]];
        });
        const auto draco =
            compareAssets(plainGlb(shapes, reportOf(1, 1)).bytes(), dracoGlb({clean}, 14).bytes());
        REQUIRE(draco);
        CHECK(kindOf(*draco) == "same_surface");
        CHECK(maxVoxels(*draco) > 0);
        CHECK(has((*draco)["verdict"]["text"], "same surface (max distance "));
        const auto coarse =
            compareAssets(plainGlb(shapes, reportOf(1, 1)).bytes(), dracoGlb({clean}, 4).bytes());
        REQUIRE(coarse);
        CHECK(kindOf(*coarse) == "different");
        const auto obj = compareAssets(plainGlb({plane(1, 1, 0)}).bytes(),
                                       "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
        REQUIRE(obj);
        CHECK(kindOf(*obj) == "same_surface");
        CHECK((*obj)["voxel_size"].is_null());
        CHECK((*obj)["distance"]["max"]["voxels"].is_null());
    }

    TEST_CASE("compareAssets: a surface turned inside out is not the same") {
        const Json json = compared({cube(0, 1)}, {turned(cube(0, 1))});
        CHECK(json["distance"]["max"]["meters"] == 0);
        CHECK(kindOf(json) == "different");
        CHECK(has(json["verdict"]["text"], "point elsewhere"));
        CHECK(json["normals"]["mean_degrees"].get<double>() == doctest::Approx(180));
    }

    TEST_CASE("compareAssets: a mirrored surface is as far away as its parts") {
        Shape lop = cube(0, 1);
        lop.positions[7] = Vector3f(3, 1, 1);
        Shape mirrored = turned(lop);
        for (Vector3f& position : mirrored.positions) position.x() = 1 - position.x();
        const Json json = compared({lop}, {mirrored});
        CHECK(json["a"]["area"].get<double>() == doctest::Approx(json["b"]["area"].get<double>()));
        CHECK(json["a"]["volume"].get<double>() ==
              doctest::Approx(json["b"]["volume"].get<double>()));
        CHECK(json["distance"]["a_to_b"]["meters"]["max"].get<double>() ==
              doctest::Approx(json["distance"]["b_to_a"]["meters"]["max"].get<double>()));
        CHECK(json["distance"]["max"]["meters"].get<double>() == doctest::Approx(2));
    }

    TEST_CASE("compareAssets: colours") {
        const Json json =
            compared({painted(cube(0, 1), {1, 0, 0})}, {painted(cube(0, 1), {0, 1, 0})});
        CHECK(json["colors"]["different"] == 1);
        CHECK(kindOf(json) == "same_surface");
        CHECK(has(json["verdict"]["text"], "other colours on 100 %"));
    }

    TEST_CASE("compareAssets: parts of the same name are compared with each other") {
        const Shape low = plane(2, 2, 0);
        const Shape high = plane(2, 2, 1);
        const Json swapped = compared({low, high}, {high, low});
        REQUIRE(swapped["parts"].size() == 2);
        CHECK(swapped["parts"][1]["name"] == "part 2");
        CHECK(swapped["parts"][1]["a_to_b"]["meters"]["max"].get<double>() == doctest::Approx(1));
        CHECK(swapped["distance"]["max"]["meters"].get<double>() == doctest::Approx(1));
        // Other names: everything with everything.
        const Json whole = compared({low, high}, {low, high, plane(2, 2, 0.5F)});
        CHECK(whole["parts"].empty());
        CHECK(whole["distance"]["a_to_b"]["meters"]["max"] == 0);
        CHECK(whole["distance"]["b_to_a"]["meters"]["max"].get<double>() == doctest::Approx(0.5));
    }

    TEST_CASE("compareAssets: maxDistance decides how the run ends") {
        const std::vector<Shape> a{plane(4, 4, 0)};
        const std::vector<Shape> b{plane(4, 4, 0.25F)};  // half a voxel
        CHECK(exitOf(compared(a, b, {.maxDistance = 0.51})) == ExitCode::ok);
        const Json exceeded = compared(a, b, {.maxDistance = 0.49});
        CHECK(exitOf(exceeded) == ExitCode::failed);
        CHECK(has(comparisonTable(exceeded), "exceeded"));
        CHECK(exitOf(compared(a, b, {.voxelSize = 1, .maxDistance = 0.3})) == ExitCode::ok);
        const auto unknown =
            compareAssets(plainGlb(a).bytes(), plainGlb(b).bytes(), {.maxDistance = 1});
        REQUIRE_FALSE(unknown);
        CHECK(unknown.error().exit == ExitCode::usage);
    }

    TEST_CASE("reject: the file that is wrong is named") {
        const std::string good = plainGlb({cube(0, 1)}).bytes();
        const auto second = compareAssets(good, good.substr(0, 40), {.nameB = "b.glb"});
        REQUIRE_FALSE(second);
        CHECK(second.error().exit == ExitCode::refused);
        CHECK(has(describe(second.error()), "b.glb: "));
        Shape flat = cube(0, 1);
        for (Vector3f& position : flat.positions) position = Vector3f(1, 0, 0) * position.x();
        const auto first = compareAssets(plainGlb({flat}).bytes(), good, {.nameA = "a.glb"});
        REQUIRE_FALSE(first);
        CHECK(has(describe(first.error()), "a.glb: none of its triangles has an area"));
    }

    TEST_CASE("determinism: threads 1, 2, 7 give the same answer") {
        const std::string a = plainGlb({ball({0, 0, 0}, 1, 20), cube(3, 4)}).bytes();
        const std::string b = plainGlb({ball({0.1F, 0, 0}, 1, 22), cube(3, 4.1F)}).bytes();
        const auto one = compareAssets(a, b, {.threads = 1});
        REQUIRE(one);
        CHECK(*compareAssets(a, b, {.threads = 2}) == *one);
        CHECK(*compareAssets(a, b, {.threads = 7}) == *one);
    }

    TEST_CASE("comparisonTable: names from files cannot steer the terminal") {
        GlbSource glb = plainGlb({cube(0, 1), cube(2, 3)}, reportOf(1, 1));
        glb.json["nodes"][0]["name"] = "\x1b[2Jred";
        Json other = reportOf(1, 1);
        other["options"]["\x1b]0;x"] = "\x1b[31m";
        GlbSource second = plainGlb({cube(0, 1), cube(2, 3)}, other);
        second.json["nodes"][0]["name"] = "\x1b[2Jred";
        const auto json =
            compareAssets(glb.bytes(), second.bytes(), {.nameA = "a\n.glb", .nameB = "b\x07.glb"});
        REQUIRE(json);
        const std::string table = comparisonTable(*json);
        CHECK(has(table, "?[2Jred"));
        for (const char c : table) CHECK((c == '\n' || static_cast<unsigned char>(c) >= 0x20));
        CHECK(has(table, "a?.glb"));
    }

    // Both used to take far more: each part looked at the vertices of all, and each search
    // met every copy of a triangle. Time of the processors, as others may use them too.
    TEST_CASE("regression: very many parts, and very many copies of one triangle") {
        std::vector<Shape> parts;
        for (int i = 0; i < 20'000; ++i)
            parts.push_back(shifted(cube(0, 1), Vector3f(2.0F * static_cast<float>(i), 0, 0)));
        parts[0].positions.resize(4'000'000, Vector3f::Zero());
        Shape copies;
        copies.positions = {{0, 0, 0}, {1, 0, 0.3F}, {0, 1, 0.7F}};
        for (std::uint32_t i = 0; i < 100'000; ++i)
            copies.triangles.push_back({i % 3, (i + 1) % 3, (i + 2) % 3});
        for (const auto& shapes : {parts, std::vector<Shape>{copies}}) {
            const std::clock_t start = std::clock();
            const std::string bytes = plainGlb(shapes).bytes();
            const auto json = compareAssets(bytes, bytes);
            REQUIRE(json);
            CHECK((*json)["distance"]["max"]["meters"] == 0);
            const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
            CHECK(seconds < 5);
        }
    }
}
