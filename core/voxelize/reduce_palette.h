#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/brick_grid.h"
#include "core/grid/material.h"

namespace rivage::core {

/// A palette with few enough entries, and what it cost.
struct ReducedPalette {
    IdVector<MaterialId, Material> materials{1};  ///< entry 0 is empty space
    std::vector<MaterialId> newId;                ///< by old id
    std::uint64_t colors = 0;                     ///< entries in use
    bool reduced = false;                         ///< colours were changed
    double errorMax = 0;   ///< largest difference of a voxel's colour, OKLab distance
    double errorMean = 0;  ///< over all voxels
};

/// Voxels of each material, by id. Means nothing once `run` asked to stop.
[[nodiscard]] std::vector<std::uint64_t> countByMaterial(const BrickGrid& voxels,
                                                         std::size_t materials,
                                                         const RunContext& run);

/// A palette of at most `limit` materials. If there are no more in use, all stay as they are:
/// each at the entry that the artist knows it by (`Material::source`) where these are distinct and
/// in 1..limit, else in their order. If there are more, those that differ in colour alone are
/// joined: the colours of each such group are cut along their longest axis at the mean, the box
/// with the largest squared error first, and then moved to the means of what is nearest to them.
/// @param voxels  of each material, by id; weighs the colours
/// @errors tooManyLabels if more than `limit` materials differ in more than colour; cancelled
/// @cost   O(limit * materials) time per round, at most 16 rounds
/// @source median cut (Heckbert 1982) with the error as in Wu 1991; k-means (Lloyd 1982)
Result<ReducedPalette> reducePalette(const IdVector<MaterialId, Material>& materials,
                                     const std::vector<std::uint64_t>& voxels, std::size_t limit,
                                     const RunContext& run);

}  // namespace rivage::core
