#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/surface/digital_surface.h"
#include "core/surface/surfel_links.h"

namespace rivage::core {

/// Visits the patch around a surfel: the surfels of its interface that are reached from it through
/// links and whose centres all lie within a Euclidean distance. One walker serves one thread.
class PatchWalker {
public:
    PatchWalker(const DigitalSurface& surface, const SurfelLinks& links)
        : surface_(surface), links_(links), table_(kInitialCapacity) {}

    /// Calls `visit(surfel, offset, distance)` once per surfel of the patch, breadth first; the
    /// offset goes from the centre to the surfel.
    /// @param radius  in units of the shortest side of a voxel; the centre surfel itself is always
    ///                visited
    template <typename Visit>
    void walk(SurfelId centre, double radius, Visit&& visit) {
        walkScales(centre, std::span(&radius, 1), visit, [](std::size_t) { return true; });
    }

    /// The patches of growing radii, each containing the last: visits the surfels that radius k
    /// adds, then calls `done(k)`, which tells whether to go on.
    /// @param radii  ascending
    template <typename Visit, typename Done>
    void walkScales(SurfelId centre, std::span<const double> radii, Visit&& visit, Done&& done);

private:
    static constexpr std::size_t kInitialCapacity = 1024;  // a power of two

    struct Entry {
        std::uint32_t surfel = 0;
        std::uint32_t walk = 0;
    };
    struct Reached {
        SurfelId surfel;
        Vec3d offset;
        double squared;
    };

    /// Marks a surfel as seen in this walk; false if it already was.
    bool insert(SurfelId s);
    void grow();
    [[nodiscard]] Reached reach(SurfelId s, const Vec3i& origin) const {
        const Vec3d offset =
            (surface_.doubleCentre(s) - origin).cast<double>().cwiseProduct(surface_.spacing) / 2;
        return {s, offset, offset.squaredNorm()};
    }

    const DigitalSurface& surface_;
    const SurfelLinks& links_;
    std::vector<Entry> table_;  // open addressing; entries of older walks count as free
    std::size_t used_ = 0;
    std::vector<SurfelId> queue_;
    std::vector<Reached> beyond_;  // reached, but outside the radius so far
    std::uint32_t walk_ = 0;
};

inline bool PatchWalker::insert(SurfelId s) {
    constexpr std::uint32_t kFibonacci = 2654435769U;  // 2^32 / golden ratio
    const std::size_t mask = table_.size() - 1;
    for (std::size_t at = (index(s) * kFibonacci >> 8) & mask;; at = (at + 1) & mask) {
        if (table_[at].walk != walk_) {
            table_[at] = {index(s), walk_};
            if (++used_ * 2 > table_.size()) grow();
            return true;
        }
        if (table_[at].surfel == index(s)) return false;
    }
}

inline void PatchWalker::grow() {
    std::vector<Entry> old(table_.size() * 2);
    old.swap(table_);
    used_ = 0;
    for (const Entry& entry : old)
        if (entry.walk == walk_) insert(SurfelId{entry.surfel});
}

template <typename Visit, typename Done>
void PatchWalker::walkScales(SurfelId centre, std::span<const double> radii, Visit&& visit,
                             Done&& done) {
    ++walk_;
    used_ = 0;
    queue_.assign(1, centre);
    beyond_.clear();
    insert(centre);
    const Vec3i origin = surface_.doubleCentre(centre);
    visit(centre, Vec3d(Vec3d::Zero()), 0.0);
    const auto enter = [&](const Reached& reached) {
        queue_.push_back(reached.surfel);
        visit(reached.surfel, reached.offset, std::sqrt(reached.squared));
    };
    std::size_t head = 0;
    for (std::size_t scale = 0; scale < radii.size(); ++scale) {
        const double limit = radii[scale] * radii[scale];
        std::size_t kept = 0;
        for (const Reached& reached : beyond_) {
            if (reached.squared <= limit)
                enter(reached);
            else
                beyond_[kept++] = reached;
        }
        beyond_.resize(kept);
        for (; head < queue_.size(); ++head)
            for (const SurfelId next : links_[queue_[head]]) {
                if (next == kNone<SurfelId> || !insert(next)) continue;
                const Reached reached = reach(next, origin);
                if (reached.squared <= limit)
                    enter(reached);
                else if (scale + 1 < radii.size())
                    beyond_.push_back(reached);
            }
        if (!done(scale)) return;
    }
}

}  // namespace rivage::core
