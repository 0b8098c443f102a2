#include "core/voxelize/thin_parts.h"

#include <algorithm>
#include <tuple>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

bool before(const VotedVoxel& a, const VotedVoxel& b) {
    const auto key = [](const VotedVoxel& v) {
        return std::make_tuple(index(v.label), v.at.z(), v.at.y(), v.at.x());
    };
    return key(a) < key(b);
}

/// Calls `visit` for the 26 neighbours of a voxel, in a fixed order.
template <typename Visit>
void forEachNeighbour(const Vec3i& at, Visit&& visit) {
    for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                if (dx != 0 || dy != 0 || dz != 0) visit(Vec3i(at + Vec3i(dx, dy, dz)));
}

/// The candidates of one label.
class Candidates {
public:
    Candidates(VoxelGrid& coarse, const VotedVoxel* begin, const VotedVoxel* end, MaterialId stand)
        : coarse_(coarse),
          begin_(begin),
          end_(end),
          label_(begin->label),
          stand_(stand),
          thin_(static_cast<std::size_t>(end - begin), false),
          seenThin_(thin_) {}

    std::uint64_t keep(const RunContext& run) {
        std::vector<bool> seen(static_cast<std::size_t>(end_ - begin_), false);
        serialFor(
            seen.size(), run,
            [&](std::size_t i) {
                if (seen[i]) return;
                const auto part = connected(i, seen, [](std::size_t) { return true; });
                const bool touches = std::any_of(part.begin(), part.end(), [&](std::size_t c) {
                    return touchesKept(begin_[c].at);
                });
                if (touches)
                    keepThin(part);
                else
                    take(part, true);
            },
            64);
        for (const std::size_t c : taken_) coarse_.voxels.set(begin_[c].at, stand_);
        return taken_.size();
    }

private:
    [[nodiscard]] bool isKept(const Vec3i& at) const { return coarse_.labelAt(at) == label_; }
    [[nodiscard]] std::size_t find(const Vec3i& at) const {
        const VotedVoxel* found = std::lower_bound(begin_, end_, VotedVoxel{at, label_}, before);
        return found != end_ && found->at == at ? static_cast<std::size_t>(found - begin_) : kNo;
    }
    [[nodiscard]] bool touchesKept(const Vec3i& at) const {
        bool touches = false;
        forEachNeighbour(at, [&](const Vec3i& other) { touches = touches || isKept(other); });
        return touches;
    }

    /// The candidates that `has` takes and that hang together with candidate i.
    template <typename Has>
    std::vector<std::size_t> connected(std::size_t i, std::vector<bool>& seen, Has&& has) const {
        std::vector<std::size_t> part{i};
        seen[i] = true;
        for (std::size_t next = 0; next < part.size(); ++next)
            forEachNeighbour(begin_[part[next]].at, [&](const Vec3i& other) {
                const std::size_t c = find(other);
                if (c == kNo || seen[c] || !has(c)) return;
                seen[c] = true;
                part.push_back(c);
            });
        return part;
    }

    /// Whether no 2 x 2 x 2 cube around a voxel is full of the label and its candidates.
    [[nodiscard]] bool isThin(const Vec3i& at) const {
        for (int cube = 0; cube < 8; ++cube) {
            const Vec3i low = at - Vec3i(cube & 1, cube >> 1 & 1, cube >> 2);
            bool full = true;
            for (int v = 0; v < 8 && full; ++v) {
                const Vec3i voxel = low + Vec3i(v & 1, v >> 1 & 1, v >> 2);
                full = isKept(voxel) || find(voxel) != kNo;
            }
            if (full) return false;
        }
        return true;
    }

    void keepThin(const std::vector<std::size_t>& part) {
        for (const std::size_t c : part) thin_[c] = isThin(begin_[c].at);
        for (const std::size_t c : part) {
            if (!thin_[c] || seenThin_[c]) continue;
            const auto piece =
                connected(c, seenThin_, [&](std::size_t i) -> bool { return thin_[i]; });
            const bool standsOff = std::any_of(piece.begin(), piece.end(), [&](std::size_t i) {
                return !touchesKept(begin_[i].at);
            });
            if (standsOff) take(piece, false);
        }
    }

    /// Marks voxels to be taken, those of other solid labels only if asked to.
    void take(const std::vector<std::size_t>& part, bool fromSolid) {
        for (const std::size_t c : part) {
            const Vec3i& at = begin_[c].at;
            const Label owner = coarse_.labelAt(at);
            if (owner == Label{0} || (fromSolid && !isAlone(at, owner))) taken_.push_back(c);
        }
    }
    [[nodiscard]] bool isAlone(const Vec3i& at, Label owner) const {
        bool alone = true;
        forEachNeighbour(
            at, [&](const Vec3i& other) { alone = alone && coarse_.labelAt(other) != owner; });
        return alone;
    }

    static constexpr std::size_t kNo = ~std::size_t{0};
    VoxelGrid& coarse_;
    const VotedVoxel* begin_;  // sorted by (z, y, x)
    const VotedVoxel* end_;
    Label label_;
    MaterialId stand_;
    std::vector<bool> thin_;
    std::vector<bool> seenThin_;
    std::vector<std::size_t> taken_;
};

}  // namespace

std::uint64_t keepThinParts(VoxelGrid& coarse, std::vector<VotedVoxel> candidates,
                            const std::vector<MaterialId>& stand, const RunContext& run) {
    std::sort(candidates.begin(), candidates.end(), before);
    std::uint64_t kept = 0;
    const VotedVoxel* const end = candidates.data() + candidates.size();
    for (const VotedVoxel* begin = candidates.data(); begin != end && !run.stopped();) {
        const VotedVoxel* next =
            std::find_if(begin, end, [&](const VotedVoxel& v) { return v.label != begin->label; });
        kept += Candidates(coarse, begin, next, stand[index(begin->label)]).keep(run);
        begin = next;
    }
    return kept;
}

}  // namespace rivage::core
