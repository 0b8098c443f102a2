#pragma once

#include "core/normals/disc.h"
#include "core/normals/normal_field.h"
#include "core/normals/patch_walker.h"

namespace rivage::core {

/// The disc around a surfel that is most convincing as a piece of a digital plane.
struct PlaneDisc {
    Vec3d normal = Vec3d::Zero();
    double radius = 0;
    double score = 0;  ///< radius^3, less what is not flat
};

/// What the discs of the neighbourhood say about a surfel.
struct DiscVote {
    Vec3d normal = Vec3d::Zero();
    /// How far the normals that were voted for spread, radians: below 0.05 on planar parts.
    double spread = 0;
    /// Radius of the largest plane disc that covers the surfel.
    double planeRadius = 0;
};

/// Estimates normals from a vote of discs of several sizes: near a crease those discs win that do
/// not cross it, so planar parts keep their normals up to the edge.
///
/// Votes count more where the surfel's own trivial normal fits, and a mean shift with a narrowing
/// window finds the place where most votes agree instead of their mean.
/// @source METHOD.md 3.5 (b); ours: the weight of the trivial normal and the mean shift, which take
///         the error at 1 to 3 voxels from the edges of rotated boxes from 1.8 to 0.6 degrees
class DiscVoting {
public:
    /// @param largest  radius of the largest discs
    explicit DiscVoting(const DigitalSurface& surface, double largest);

    /// Weighs the discs around a surfel and keeps the best.
    void choose(SurfelId s, PatchWalker& walker);
    /// The vote for a surfel. Its voters, within the largest radius, must have been chosen for.
    [[nodiscard]] DiscVote vote(SurfelId s, PatchWalker& walker) const;

private:
    struct Ballot {
        Vec3d normal;
        double weight;
    };

    void consider(SurfelId s, double radius, const Disc& disc);
    [[nodiscard]] double weight(SurfelId voter, SurfelId s, double distance) const;
    [[nodiscard]] static DiscVote count(const std::vector<Ballot>& ballots, const Vec3d& fallback);

    const DigitalSurface& surface_;
    std::vector<double> radii_;
    IdVector<SurfelId, PlaneDisc> best_;
};

}  // namespace rivage::core
