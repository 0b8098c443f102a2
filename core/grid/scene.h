#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/options.h"
#include "core/base/result.h"
#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// A placed model. Voxel v of the model lies at `rotation * v + translation` of the scene, where
/// for negative rows of `rotation` the cube is meant, not its low corner: see `mergeScene`.
struct Instance {
    std::vector<int> frames;             ///< model per animation key, at least one
    std::vector<int> frameTimes;         ///< frame from which each key holds; empty: 0, 1, 2, ...
    Mat3i rotation = Mat3i::Identity();  ///< signed permutation; mirrors are allowed
    Vec3i translation = Vec3i::Zero();   ///< scene position of the rotated pivot floor(size / 2)
    bool centered = true;  ///< false: `translation` places the low corner of the rotated model
    bool hidden = false;   ///< it, a group above it or its layer is hidden
    int layer = -1;
    std::string name;
};

/// What a file holds before it is merged: models, where they stand, and one material table.
struct Scene {
    std::vector<BrickGrid> models;
    std::vector<Instance> instances;
    IdVector<MaterialId, Material> materials{1};  ///< labels are not assigned yet
    Vec3d spacing = Vec3d::Ones();                ///< relative sides of a voxel, as the file says
    bool laterInstanceWins = true;                ///< which instance is seen where two overlap
    GridFormat format = GridFormat::automatic;
    std::string formatDetail;           ///< e.g. "vox 200"
    std::vector<std::string> warnings;  ///< for the report
};

/// Merges the visible instances of one frame to a single grid and gives every material its label.
/// Unused materials are dropped; the labels are numbered from 1 in the order of the rule that
/// made them (class, palette entry, stored value, or the label map).
/// @errors emptyGrid if no voxel is left; tooLarge by voxels or extent; tooManyLabels;
///         invalidOption if the label map names values twice; cancelled
/// @cost   O(voxels)
Result<VoxelGrid> mergeScene(const Scene& scene, const InputOptions& options,
                             const RunContext& run);

}  // namespace rivage::core
