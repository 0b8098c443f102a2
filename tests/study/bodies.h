#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/study/solid.h"
#include "tests/support/shapes.h"

/// The shapes of the study, in object units: each fits a ball of radius 0.44 about the origin, so
/// that a grid of N^3 voxels of size 1/N holds it in any orientation.
namespace rivage::study {

struct Body {
    std::string name;
    int labels = 1;
    bool creased = false;  ///< has creases whose distance is known
    std::function<int(const Vec3d&)> labelAt;
    /// Of the true interface with this label pair; `Foot::normal` goes from inner to outer. Where
    /// labels meet, interfaces are continued behind their border.
    std::function<Foot(const LabelPair&, const Vec3d&)> foot;
};

/// All shapes: nine solids, then five with several labels.
[[nodiscard]] const std::vector<Body>& bodies();
[[nodiscard]] const Body& body(const std::string& name);

/// A random rotation, and a shift of up to half a voxel along each axis: pose 0, 1, ...
struct Pose {
    Mat3d rotation;
    Vec3d shift;  ///< voxels
};
[[nodiscard]] Pose pose(std::uint32_t number);

/// A body in a grid of resolution^3 voxels; lengths of the shape are in voxels.
[[nodiscard]] Shape digitize(const Body& body, int resolution, const Pose& pose);

}  // namespace rivage::study
