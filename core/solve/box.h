#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "core/surface/digital_surface.h"

namespace rivage::core {

/// The box |d_k| <= limit_k around a rest position, for one displacement. A limit of 0 holds a
/// coordinate, an infinite one is no limit at all.
struct Box {
    Vec3d limit = Vec3d::Constant(std::numeric_limits<double>::infinity());

    [[nodiscard]] Vec3d project(const Vec3d& d) const { return d.cwiseMin(limit).cwiseMax(-limit); }
    /// The displacement of a position that a solver gave: one that rounding took off its side is on
    /// it again.
    [[nodiscard]] Vec3d recover(const Vec3d& position, const Vec3d& rest) const {
        constexpr double kRounding = 1e-11;  // of coordinates up to 2^15, twice
        Vec3d d = project(position - rest);
        for (int k = 0; k < 3; ++k)
            if (limit[k] - std::abs(d[k]) < kRounding) d[k] = std::copysign(limit[k], d[k]);
        return d;
    }
    /// The pointel stays where it is, wherever that is.
    bool held = false;
    /// True if coordinate k may move at all.
    [[nodiscard]] bool movable(int k) const { return !held && limit[k] > 0; }
    /// The projected gradient, 0 exactly where the KKT conditions hold: the gradient without what
    /// pushes against a side.
    [[nodiscard]] Vec3d projectedGradient(const Vec3d& d, const Vec3d& g) const {
        Vec3d result = g;
        for (int k = 0; k < 3; ++k) {
            const bool outward = (d[k] >= limit[k] && g[k] < 0) || (d[k] <= -limit[k] && g[k] > 0);
            if (!movable(k) || outward) result[k] = 0;
        }
        return result;
    }
};

/// The boxes of all pointels: the displacement limit along each axis in sides of a voxel, and
/// nothing at all for the fixed coordinates.
class Boxes {
public:
    /// @param held  1 for the pointels that stay where they are; nullptr for none
    Boxes(const DigitalSurface& surface, std::optional<double> displacementLimit,
          const IdVector<PointelId, std::uint8_t>* held = nullptr)
        : surface_(surface), held_(held) {
        if (displacementLimit) free_.limit = *displacementLimit * surface.spacing;
    }
    [[nodiscard]] bool holds() const { return held_ != nullptr; }
    [[nodiscard]] Box operator[](PointelId i) const {
        Box box = free_;
        box.held = held_ != nullptr && (*held_)[i] != 0;
        if (!surface_.fixedAxes.empty())
            for (int k = 0; k < 3; ++k)
                if (surface_.fixedAxes[i] >> k & 1) box.limit[k] = 0;
        return box;
    }

private:
    const DigitalSurface& surface_;
    const IdVector<PointelId, std::uint8_t>* held_;
    Box free_;
};

}  // namespace rivage::core
