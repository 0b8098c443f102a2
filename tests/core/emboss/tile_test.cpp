#include "core/emboss/tile.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/emboss/patterns.h"

using namespace rivage::core;

namespace {

constexpr double kFine = 1e-3;  // a step at which nothing is averaged

constexpr TileKind kKinds[] = {TileKind::brick,    TileKind::planks, TileKind::shingles,
                               TileKind::pantiles, TileKind::cobble, TileKind::panels};

TileOptions own(std::vector<std::vector<double>> heights, double size, double depth) {
    return {.heights = std::move(heights), .size = size, .depth = depth};
}

}  // namespace

TEST_SUITE_BEGIN("core/emboss");

TEST_CASE("HeightTile: rows run from top to bottom, 1 stands out, the mean is 0") {
    const HeightTile tile(own({{0, 1}, {0.5, 0.5}}, 2, 0.4), kFine);
    CHECK(tile.range() == doctest::Approx(0.4));
    CHECK(tile.at(1.5, 1.5) == doctest::Approx(0.2));   // right, above
    CHECK(tile.at(0.5, 1.5) == doctest::Approx(-0.2));  // left, above
    CHECK(tile.at(0.5, 0.5) == doctest::Approx(0));
    CHECK(tile.at(1.5 - 2, 1.5 + 4) == doctest::Approx(0.2));  // repeated
    CHECK(tile.at(1, 1.5) == doctest::Approx(0));              // between
}

TEST_CASE("HeightTile: turns counter-clockwise") {
    TileOptions options = own({{0, 0}, {0, 1}}, 2, 0.4);  // high in the right, below
    const double places[4][2] = {{1.5, 0.5}, {-0.5, 1.5}, {-1.5, -0.5}, {0.5, -1.5}};
    for (int quarter = 0; quarter < 4; ++quarter) {
        options.turn = 90 * quarter;
        const HeightTile tile(options, kFine);
        CHECK(tile.at(places[quarter][0], places[quarter][1]) == doctest::Approx(0.3));
    }
}

TEST_CASE("HeightTile: a constant tile is exactly flat") {
    const HeightTile tile(own({{0.3, 0.3, 0.3}}, 1.7, 1), 0.25);
    CHECK(tile.range() == 0);
    CHECK(tile.at(0.1, 7.3) == 0);
}

TEST_CASE("HeightTile: what is finer than the step is averaged, not lost") {
    std::vector<std::vector<double>> comb(1);
    for (int i = 0; i < 64; ++i) comb[0].push_back(i % 8 == 0 ? 0 : 1);
    const HeightTile tile(own(comb, 2, 1), 0.25);  // a groove each quarter of a voxel
    for (int i = 0; i < 20; ++i) CHECK(tile.at(0.173 * i, 0) == doctest::Approx(0).epsilon(1e-9));
}

TEST_CASE("makePattern: fills 0 to 1, and continues across its borders") {
    for (const TileKind kind : kKinds) {
        CAPTURE(tileName(kind));
        const HeightMap map = makePattern(kind);
        const auto [low, high] = std::minmax_element(map.values.begin(), map.values.end());
        CHECK(*low == 0);
        CHECK(*high == 1);
        // The steps across the border are like those inside: their mean square is no larger than
        // three times that of the roughest line inside.
        const auto at = [&](int x, int y) {
            const int column = (x + map.columns) % map.columns;
            const int row = (y + map.rows) % map.rows;
            return map.values[static_cast<std::size_t>(row * map.columns + column)];
        };
        const auto roughness = [&](int line, bool across) {
            double sum = 0;
            for (int i = 0; i < map.columns; ++i) {
                const double step =
                    across ? at(line, i) - at(line - 1, i) : at(i, line) - at(i, line - 1);
                sum += step * step;
            }
            return sum;
        };
        for (const bool across : {true, false}) {
            double inside = 0;
            for (int line = 1; line < map.columns; ++line)
                inside = std::max(inside, roughness(line, across));
            CHECK(roughness(0, across) <= 3 * inside);
        }
    }
}

TEST_SUITE_END();
