#pragma once

#include <algorithm>

#include "core/base/parallel.h"
#include "core/normals/normal_field.h"

namespace rivage::core {

/// Lets a field diffuse through the links, for a time of its own at each surfel: a wide average at
/// 5 reads a round, where a patch of radius r has r^2 surfels and more.
///
/// @param rounds  per surfel; a link conducts until the smaller time of its two surfels
/// @return  vectors are not normalized: where those of a window differ, their mean is shorter
/// @errors  cancelled
/// @cost    O(surfels) a round
/// @source  ours; METHOD.md, addendum: a fixed radius gets worse as shapes grow
template <typename Value>
Result<IdVector<SurfelId, Value>> diffuse(const SurfelLinks& links, IdVector<SurfelId, Value> field,
                                          const IdVector<SurfelId, float>& rounds,
                                          const RunContext& run) {
    constexpr float kShare = 0.2F;  // of each of the four links; the surfel itself keeps the rest
    float longest = 0;
    for (const float time : rounds) longest = std::max(longest, time);
    IdVector<SurfelId, Value> next = field;
    for (float round = 0; round < longest; ++round) {
        parallelBlocks(field.size(), 4096, run, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const SurfelId s{static_cast<std::uint32_t>(i)};
                next[s] = field[s];
                if (rounds[s] <= round) continue;
                for (const SurfelId g : links[s]) {
                    if (g == kNone<SurfelId>) continue;
                    const float left = std::min(rounds[s], rounds[g]) - round;
                    if (left > 0) next[s] += kShare * std::min(left, 1.0F) * (field[g] - field[s]);
                }
            }
        });
        if (run.stopped()) return fail(run.stopError());
        std::swap(field, next);
    }
    return field;
}

/// Rounds of `diffuse` that widen hat weights from one radius to another; 0 if it is no larger.
[[nodiscard]] double roundsBetween(double radius, double larger);

/// Curvature, per voxel, of the surface behind a field of unit normals: how much shorter they
/// become when they diffuse. The root of the sum of the squares of both principal curvatures over
/// 2, so 1 / R on a ball.
/// @errors  cancelled
/// @cost    O(surfels), 10 rounds
Result<IdVector<SurfelId, float>> curvatures(const SurfelLinks& links, const NormalField& normals,
                                             const RunContext& run);

/// The largest value of each surfel's neighbourhood of so many links.
template <typename Value>
IdVector<SurfelId, Value> dilate(const SurfelLinks& links, IdVector<SurfelId, Value> values,
                                 int rounds, const RunContext& run) {
    IdVector<SurfelId, Value> next = values;
    for (int round = 0; round < rounds && !run.stopped(); ++round) {
        parallelBlocks(values.size(), 4096, run, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const SurfelId s{static_cast<std::uint32_t>(i)};
                Value most = values[s];
                for (const SurfelId g : links[s])
                    if (g != kNone<SurfelId>) most = std::max(most, values[g]);
                next[s] = most;
            }
        });
        std::swap(values, next);
    }
    return values;
}

}  // namespace rivage::core
