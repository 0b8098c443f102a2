#include "core/emboss/tile.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/emboss/patterns.h"

namespace rivage::core {
namespace {

constexpr double kOwnSize = 4;     // voxels, where the caller says nothing
constexpr double kOwnDepth = 0.2;  // voxels

HeightMap heightsOf(const TileOptions& options) {
    if (options.kind != TileKind::own) return makePattern(options.kind);
    HeightMap map{static_cast<int>(options.heights.front().size()),
                  static_cast<int>(options.heights.size()),
                  {},
                  kOwnSize,
                  kOwnDepth};
    for (auto row = options.heights.rbegin(); row != options.heights.rend(); ++row)
        map.values.insert(map.values.end(), row->begin(), row->end());
    return map;
}

/// Averages over `width` values along one axis of a periodic map.
void average(HeightMap& map, double width, bool alongRows) {
    if (width <= 1) return;
    const int count = alongRows ? map.columns : map.rows;
    const int lines = alongRows ? map.rows : map.columns;
    const int reach = static_cast<int>(std::ceil(0.5 * width + 0.5));
    const auto at = [&](int line, int i) -> double& {
        const int x = alongRows ? i : line;
        const int y = alongRows ? line : i;
        return map.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.columns) +
                          static_cast<std::size_t>(x)];
    };
    std::vector<double> averaged(static_cast<std::size_t>(count));
    for (int line = 0; line < lines; ++line) {
        for (int i = 0; i < count; ++i) {
            double sum = 0;
            for (int d = -reach; d <= reach; ++d) {
                const double overlap =
                    std::min(d + 0.5, 0.5 * width) - std::max(d - 0.5, -0.5 * width);
                if (overlap <= 0) continue;
                sum += overlap * at(line, ((i + d) % count + count) % count);
            }
            averaged[static_cast<std::size_t>(i)] = sum / width;
        }
        for (int i = 0; i < count; ++i) at(line, i) = averaged[static_cast<std::size_t>(i)];
    }
}

int wrapped(double cell, int count) {
    const int i = static_cast<int>(std::fmod(cell, count));
    return i < 0 ? i + count : i;
}

}  // namespace

HeightTile::HeightTile(const TileOptions& options, double step) {
    HeightMap map = heightsOf(options);
    columns_ = map.columns;
    rows_ = map.rows;
    perVoxelU_ = perVoxelV_ = columns_ / options.size.value_or(map.size);
    quarterTurns_ = options.turn / 90;
    const auto [low, high] = std::minmax_element(map.values.begin(), map.values.end());
    const double depth = options.depth.value_or(map.depth);
    range_ = depth * (*high - *low);
    heights_.assign(map.values.size(), 0);
    if (range_ == 0) return;  // exactly flat, whatever rounding would make of a mean
    average(map, perVoxelU_ * step, true);
    average(map, perVoxelV_ * step, false);
    const double mean = std::accumulate(map.values.begin(), map.values.end(), 0.0) /
                        static_cast<double>(map.values.size());
    for (std::size_t i = 0; i < heights_.size(); ++i) heights_[i] = depth * (map.values[i] - mean);
}

double HeightTile::at(double u, double v) const {
    for (int turn = 0; turn < quarterTurns_; ++turn) {
        const double right = v;
        v = -u;
        u = right;
    }
    const double x = u * perVoxelU_ - 0.5;
    const double y = v * perVoxelV_ - 0.5;
    const double left = std::floor(x);
    const double low = std::floor(y);
    const int x0 = wrapped(left, columns_);
    const int y0 = wrapped(low, rows_);
    const int x1 = (x0 + 1) % columns_;
    const int y1 = (y0 + 1) % rows_;
    const auto height = [&](int column, int row) {
        return heights_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                        static_cast<std::size_t>(column)];
    };
    const double right = x - left;
    const double up = y - low;
    return (1 - up) * ((1 - right) * height(x0, y0) + right * height(x1, y0)) +
           up * ((1 - right) * height(x0, y1) + right * height(x1, y1));
}

const char* tileName(TileKind kind) {
    switch (kind) {
        case TileKind::own: return "own";
        case TileKind::brick: return "brick";
        case TileKind::planks: return "planks";
        case TileKind::shingles: return "shingles";
        case TileKind::pantiles: return "pantiles";
        case TileKind::cobble: return "cobble";
        case TileKind::panels: return "panels";
    }
    return "";
}

}  // namespace rivage::core
