#include "core/emboss/patterns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace rivage::core {
namespace {

constexpr int kSide = 128;  // columns and rows: at 8 pieces a voxel, finer than any default needs

/// A well-mixed number from 0 to 1 of a cell and a seed.
double hashUnit(int x, int y, std::uint32_t seed) {
    std::uint32_t h = seed * 0x9e3779b9U;
    for (const int v : {x, y}) {
        h ^= static_cast<std::uint32_t>(v) + 0x9e3779b9U + (h << 6) + (h >> 2);
        h *= 0x85ebca6bU;
        h ^= h >> 13;
    }
    return static_cast<double>(h * 0xc2b2ae35U >> 8) / (1U << 24);
}

double smoothStep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double fraction(double x) { return x - std::floor(x); }
int wrapped(double cell, int count) {
    const int c = static_cast<int>(std::floor(cell)) % count;
    return c < 0 ? c + count : c;
}

/// A point of a course of equal stones: which stone, where on it (0 to 1 each way), and the
/// distance to its rim in courses.
struct Stone {
    int column;
    int course;
    double along;
    double up;
    double rim;
};

/// @param aspect  width of a stone in heights of a course
/// @param shift   of each course against the one below, in stones
Stone stoneAt(double u, double v, int columns, int courses, double aspect, double shift) {
    const double rise = v * courses;
    const int course = wrapped(rise, courses);
    const double run = u * columns + shift * course;
    const double along = fraction(run);
    const double up = fraction(rise);
    const double rim = std::min(std::min(along, 1 - along) * aspect, std::min(up, 1 - up));
    return {wrapped(run, columns), course, along, up, rim};
}

/// Bricks in running bond: raised, a little uneven, joints a tenth of a course wide on each side.
double brick(double u, double v) {
    const Stone stone = stoneAt(u, v, 2, 4, 2, 0.5);
    const double own = 0.82 + 0.18 * hashUnit(stone.column, stone.course, 11);
    const double tilt = (hashUnit(stone.column, stone.course, 12) - 0.5) * (stone.along - 0.5);
    return smoothStep(0.06, 0.15, stone.rim) * (own + 0.16 * tilt);
}

/// Boards with fine joints, each a little higher or lower, their ends staggered.
double planks(double u, double v) {
    constexpr std::array<double, 4> kShift{0, 0.45, 0.8, 0.25};
    const int board = wrapped(v * 4, 4);
    const Stone stone = stoneAt(u + kShift[static_cast<std::size_t>(board)], v, 1, 4, 4, 0);
    const double up = std::min(stone.up, 1 - stone.up);
    const double end = 4 * std::min(stone.along, 1 - stone.along);
    const double own = 0.78 + 0.22 * hashUnit(0, board, 21);
    const double cupped = 0.1 * (1 - 4 * (stone.up - 0.5) * (stone.up - 0.5));
    return smoothStep(0.03, 0.12, up) * smoothStep(0.02, 0.1, end) * (own + cupped - 0.1);
}

/// Flat wooden shingles: each row lies on the one below and is thickest at its lower edge.
double shingles(double u, double v) {
    const Stone stone = stoneAt(u, v, 4, 4, 1, 0.5);
    const double own = 0.14 * hashUnit(stone.column, stone.course, 31);
    const double uneven = 0.12 * hashUnit(stone.column, stone.course, 32);
    const double gap = smoothStep(0.02, 0.08, std::min(stone.along, 1 - stone.along));
    // Below its own lower edge a row shows the one under it, which ends there at its thinnest.
    const double edge = smoothStep(uneven, uneven + 0.05, stone.up);
    const double thickness = 0.86 - 0.62 * stone.up;
    return edge * (thickness + own) * (0.55 + 0.45 * gap) + (1 - edge) * 0.2;
}

/// Clay tiles in waves, each row on the one below.
double pantiles(double u, double v) {
    const Stone stone = stoneAt(u, v, 4, 3, 1, 0);
    const double wave = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * stone.along);
    const double edge = smoothStep(0.0, 0.06, stone.up);
    const double thickness = 0.34 * (edge * (1 - stone.up));
    return 0.62 * std::pow(wave, 0.8) + thickness;
}

/// Rounded stones of many sizes: domes over the cells of scattered points.
double cobble(double u, double v) {
    constexpr int kCells = 4;
    double nearest = 9;
    double second = 9;
    int owner = 0;
    for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) {
            const int x = static_cast<int>(std::floor(u * kCells)) + dx;
            const int y = static_cast<int>(std::floor(v * kCells)) + dy;
            const int cx = (x % kCells + kCells) % kCells;
            const int cy = (y % kCells + kCells) % kCells;
            const double px = x + 0.5 + 0.7 * (hashUnit(cx, cy, 41) - 0.5) + 0.5 * (y & 1);
            const double py = y + 0.5 + 0.7 * (hashUnit(cx, cy, 42) - 0.5);
            const double far = std::hypot(px - u * kCells, py - v * kCells);
            if (far < nearest) {
                second = std::exchange(nearest, far);
                owner = cy * kCells + cx;
            } else {
                second = std::min(second, far);
            }
        }
    const double rim = 0.5 * (second - nearest);  // distance to the border with the next stone
    const double dome =
        std::sqrt(std::clamp(1 - std::pow(1 - std::min(1.0, rim / 0.34), 2), 0., 1.));
    return smoothStep(0.03, 0.1, rim) * (0.25 + 0.55 * dome + 0.2 * hashUnit(owner, 0, 43));
}

/// Plates with a groove around each and a rivet in every corner.
double panels(double u, double v) {
    const Stone stone = stoneAt(u, v, 2, 2, 1, 0);
    const double plate = 0.7 * smoothStep(0.02, 0.07, stone.rim);
    const double x = std::min(stone.along, 1 - stone.along) - 0.16;
    const double y = std::min(stone.up, 1 - stone.up) - 0.16;
    return plate + 0.3 * (1 - smoothStep(0.03, 0.075, std::hypot(x, y)));
}

template <typename Height>
HeightMap fill(double size, double depth, Height height) {
    HeightMap map{kSide, kSide, std::vector<double>(std::size_t{kSide} * kSide), size, depth};
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            map.values[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)] =
                height((x + 0.5) / kSide, (y + 0.5) / kSide);
    const auto [low, high] = std::minmax_element(map.values.begin(), map.values.end());
    const double from = *low;
    const double range = *high - from;
    for (double& value : map.values) value = (value - from) / range;
    return map;
}

}  // namespace

HeightMap makePattern(TileKind kind) {
    switch (kind) {
        case TileKind::own: break;
        case TileKind::brick: return fill(6, 0.2, brick);
        case TileKind::planks: return fill(8, 0.2, planks);
        case TileKind::shingles: return fill(8, 0.35, shingles);
        case TileKind::pantiles: return fill(8, 0.45, pantiles);
        case TileKind::cobble: return fill(8, 0.35, cobble);
        case TileKind::panels: return fill(8, 0.2, panels);
    }
    return {};
}

}  // namespace rivage::core
