#pragma once

#include <cmath>
#include <cstdint>
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

    /// Calls `visit(surfel, distance)` once per surfel of the patch, breadth first.
    /// @param radius  voxels; the centre surfel itself is always visited
    template <typename Visit>
    void walk(SurfelId centre, double radius, Visit&& visit);

private:
    static constexpr std::size_t kInitialCapacity = 1024;  // a power of two

    /// Marks a surfel as seen in this walk; false if it already was.
    bool insert(SurfelId s);
    void grow();

    struct Entry {
        std::uint32_t surfel = 0;
        std::uint32_t walk = 0;
    };
    const DigitalSurface& surface_;
    const SurfelLinks& links_;
    std::vector<Entry> table_;  // open addressing; entries of older walks count as free
    std::vector<SurfelId> queue_;
    std::uint32_t walk_ = 0;
};

inline bool PatchWalker::insert(SurfelId s) {
    constexpr std::uint32_t kFibonacci = 2654435769U;  // 2^32 / golden ratio
    const std::size_t mask = table_.size() - 1;
    for (std::size_t at = (index(s) * kFibonacci >> 8) & mask;; at = (at + 1) & mask) {
        if (table_[at].walk != walk_) {
            table_[at] = {index(s), walk_};
            return true;
        }
        if (table_[at].surfel == index(s)) return false;
    }
}

inline void PatchWalker::grow() {
    table_.assign(table_.size() * 2, {});
    for (const SurfelId s : queue_) insert(s);
}

template <typename Visit>
void PatchWalker::walk(SurfelId centre, double radius, Visit&& visit) {
    ++walk_;
    queue_.assign(1, centre);
    insert(centre);
    const Vec3i origin = surface_.doubleCentre(centre);
    const double limit = 4 * radius * radius;
    visit(centre, 0.0);
    for (std::size_t head = 0; head < queue_.size(); ++head) {
        for (const SurfelId next : links_[queue_[head]]) {
            if (next == kNone<SurfelId>) continue;
            const int squared = (surface_.doubleCentre(next) - origin).squaredNorm();
            if (squared > limit || !insert(next)) continue;
            queue_.push_back(next);
            if (queue_.size() * 2 > table_.size()) grow();
            visit(next, std::sqrt(static_cast<double>(squared)) / 2);
        }
    }
}

}  // namespace rivage::core
