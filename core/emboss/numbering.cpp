#include "core/emboss/numbering.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace rivage::core {

bool Numbering::finish(const std::vector<Vec3i>& places, const RunContext& run) {
    // Slabs of one z each, found by counting; then every slab is sorted by itself.
    int top = 0;
    for (const Vec3i& place : places) top = std::max(top, place.z());
    std::vector<std::size_t> start(static_cast<std::size_t>(top) + 2);
    for (const Vec3i& place : places) ++start[static_cast<std::size_t>(place.z()) + 1];
    for (std::size_t z = 1; z < start.size(); ++z) start[z] += start[z - 1];
    std::vector<std::uint32_t> order(places.size());
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    serialFor(places.size(), run, [&](std::size_t n) {
        order[next[static_cast<std::size_t>(places[n].z())]++] = static_cast<std::uint32_t>(n);
    });
    rank_.resize(places.size());
    const auto before = [&](std::uint32_t m, std::uint32_t n) {
        const Vec3i& a = places[m];
        const Vec3i& b = places[n];
        if (a.y() != b.y()) return a.y() < b.y();
        return a.x() != b.x() ? a.x() < b.x() : m < n;
    };
    const auto sortSlab = [&](std::size_t z) {
        const auto at = [&](std::size_t i) {
            return order.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::sort(at(start[z]), at(start[z + 1]), before);
        for (std::size_t i = start[z]; i < start[z + 1]; ++i)
            rank_[order[i]] = static_cast<std::uint32_t>(i);
    };
    return parallelFor(start.size() - 1, run, sortSlab, 1);
}

}  // namespace rivage::core
