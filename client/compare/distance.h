#pragma once

#include <cstddef>
#include <vector>

#include "client/compare/farthest.h"
#include "client/compare/surface.h"

namespace rivage::client {

/// How far the surface A is from B: one row for each part that is compared, all samples in one list.
struct DistanceSamples {
    struct Row {
        std::size_t partA = 0;  ///< kWhole for all parts at once
        std::size_t firstSample = 0;
        std::size_t samples = 0;
        Farthest farthest;  ///< on A
    };
    static constexpr std::size_t kWhole = static_cast<std::size_t>(-1);

    std::vector<Row> rows;
    std::vector<double> distances;  ///< of points spread evenly by area
    std::vector<double> degrees;    ///< between the normals there, 0 to 180
    std::vector<char> otherColor;   ///< 1 where the colours differ; empty if they are not compared
};

/// A part of A and the part of B that it is compared with; `kWhole` for all of them.
struct PartPair {
    std::size_t a = DistanceSamples::kWhole;
    std::size_t b = DistanceSamples::kWhole;
};

struct DistanceSettings {
    std::size_t samples = 50'000;  ///< on all parts together
    double tolerance = 1e-9;       ///< a length: places on B that differ by less are as close
    double zero = 0;               ///< a length: what is below is rounding, and counts as nothing
    unsigned threads = 1;
};

/// Measures from A to B: exactly, from points of A to triangles of B. The points are all vertices
/// and a fixed sequence that is even by area; where several triangles of B are equally close, as on
/// edges, the one with the most similar normal counts, and any colour of theirs is the same colour.
/// The largest distance is then bounded from both sides (farthest.h).
/// @param pairs  parts with at least one triangle that has an area
/// @return  the same bits for any number of threads
/// @cost    O((samples + vertices) log triangles)
[[nodiscard]] DistanceSamples measureDistance(const Surface& a, const Surface& b,
                                              const std::vector<PartPair>& pairs,
                                              const DistanceSettings& settings);

}  // namespace rivage::client
