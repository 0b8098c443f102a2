#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "core/surface/digital_surface.h"

namespace rivage::core {

/// The box low_k <= d_k <= high_k of one displacement, with low <= 0 <= high. Where both are 0 a
/// coordinate is held; infinite ones are no limit at all.
struct Box {
    Vec3d low = Vec3d::Constant(-std::numeric_limits<double>::infinity());
    Vec3d high = Vec3d::Constant(std::numeric_limits<double>::infinity());

    [[nodiscard]] Vec3d project(const Vec3d& d) const { return d.cwiseMin(high).cwiseMax(low); }
    /// The displacement of a position that a solver gave: one that rounding took off its side is on
    /// it again.
    [[nodiscard]] Vec3d recover(const Vec3d& position, const Vec3d& rest) const {
        constexpr double kRounding = 1e-11;  // of coordinates up to 2^15, twice
        Vec3d d = project(position - rest);
        for (int k = 0; k < 3; ++k) {
            if (high[k] - d[k] < kRounding) d[k] = high[k];
            if (d[k] - low[k] < kRounding) d[k] = low[k];
        }
        return d;
    }
    /// The pointel stays where it is, wherever that is.
    bool held = false;
    /// True if coordinate k may move at all.
    [[nodiscard]] bool movable(int k) const { return !held && high[k] > low[k]; }
    /// The projected gradient, 0 exactly where the KKT conditions hold: the gradient without what
    /// pushes against a side.
    [[nodiscard]] Vec3d projectedGradient(const Vec3d& d, const Vec3d& g) const {
        Vec3d result = g;
        for (int k = 0; k < 3; ++k) {
            const bool outward = (d[k] >= high[k] && g[k] < 0) || (d[k] <= low[k] && g[k] > 0);
            if (!movable(k) || outward) result[k] = 0;
        }
        return result;
    }
};

/// How far a pointel may go from its rest position, voxel units: low <= 0 <= high.
struct Room {
    Vec3d low = Vec3d::Zero();
    Vec3d high = Vec3d::Zero();
};

/// The boxes of all pointels: the displacement limit along each axis in sides of a voxel, or the
/// room that each has of its own, and nothing at all for the fixed coordinates.
class Boxes {
public:
    /// @param held   1 for the pointels that stay where they are; nullptr for none
    /// @param rooms  take the place of the limit; nullptr for none
    Boxes(const DigitalSurface& surface, std::optional<double> displacementLimit,
          const IdVector<PointelId, std::uint8_t>* held = nullptr,
          const IdVector<PointelId, Room>* rooms = nullptr)
        : surface_(surface), held_(held), rooms_(rooms) {
        if (!displacementLimit) return;
        free_.high = *displacementLimit * surface.spacing;
        free_.low = -free_.high;
    }
    [[nodiscard]] bool holds() const { return held_ != nullptr; }
    [[nodiscard]] Box operator[](PointelId i) const {
        Box box = free_;
        if (rooms_ != nullptr) {
            box.low = (*rooms_)[i].low;
            box.high = (*rooms_)[i].high;
        }
        box.held = held_ != nullptr && (*held_)[i] != 0;
        if (!surface_.fixedAxes.empty())
            for (int k = 0; k < 3; ++k)
                if (surface_.fixedAxes[i] >> k & 1) box.low[k] = box.high[k] = 0;
        return box;
    }

private:
    const DigitalSurface& surface_;
    const IdVector<PointelId, std::uint8_t>* held_;
    const IdVector<PointelId, Room>* rooms_;
    Box free_;
};

}  // namespace rivage::core
