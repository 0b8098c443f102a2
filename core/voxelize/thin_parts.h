#pragma once

#include <cstdint>
#include <vector>

#include "core/base/run_context.h"
#include "core/grid/voxel_grid.h"

namespace rivage::core {

/// A voxel that has, or might have, a label.
struct VotedVoxel {
    Vec3i at;
    Label label;
};

/// Gives voxels back to labels that lost them to the majority, where that would lose a part. A set
/// of candidates of one label that hangs together and touches no voxel of it is a lost part: all
/// of it comes back. Where candidates touch the label, those come back that lie in no 2 x 2 x 2
/// cube of the label and its candidates, so are part of a wall or a wire, and hang together with
/// one that no kept voxel touches: the end of a wire, a wall that stands off. They never take the
/// last voxel of a part of another label, and thin parts take from the background only.
/// @param coarse      voxels of the majority; gets the others
/// @param candidates  labels that voxels lost, with a fair share of the samples
/// @param stand       by label, the material that stands for it
/// @return  how many voxels changed; means nothing once `run` asked to stop
/// @cost    O(candidates log candidates)
/// @source  ours; METHOD.md 5 asks for it
std::uint64_t keepThinParts(VoxelGrid& coarse, std::vector<VotedVoxel> candidates,
                            const std::vector<MaterialId>& stand, const RunContext& run);

}  // namespace rivage::core
