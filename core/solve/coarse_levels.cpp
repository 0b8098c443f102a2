#include "core/solve/coarse_levels.h"

#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::uint32_t kUnseen = ~0U;

/// Numbers the connected pieces of the pointels that share a box of side 2^level.
std::vector<std::uint32_t> findPieces(const DigitalSurface& surface, int level,
                                      std::size_t& count) {
    std::vector<std::uint32_t> pieces(surface.pointelCount(), kUnseen);
    std::vector<PointelId> queue;
    const auto box = [&](PointelId p) {
        const Vec3i& at = surface.pointels[p];
        return std::array{at.x() >> level, at.y() >> level, at.z() >> level};
    };
    count = 0;
    for (std::uint32_t first = 0; first < pieces.size(); ++first) {
        if (pieces[first] != kUnseen) continue;
        const auto piece = static_cast<std::uint32_t>(count++);
        const auto here = box(PointelId{first});
        pieces[first] = piece;
        queue.assign(1, PointelId{first});
        while (!queue.empty()) {
            const PointelId p = queue.back();
            queue.pop_back();
            for (const PointelId next : surface.neighbours[p]) {
                if (next == kNone<PointelId> || pieces[index(next)] != kUnseen) continue;
                if (box(next) != here) continue;
                pieces[index(next)] = piece;
                queue.push_back(next);
            }
        }
    }
    return pieces;
}

/// The diagonal block of each piece of P^T H P, where P moves each piece as one.
std::vector<Mat3d> pieceBlocks(const Energy& energy, const std::vector<std::uint32_t>& pieces,
                               std::size_t count) {
    std::vector<Mat3d> blocks(count, Mat3d::Zero());
    std::array<std::pair<std::uint32_t, double>, kSlots + 1> sums;
    energy.forEachSquare([&](std::span<const Energy::Coefficient> row, const Mat3d& block) {
        std::size_t used = 0;
        for (const auto& [pointel, value] : row) {
            const std::uint32_t piece = pieces[index(pointel)];
            std::size_t at = 0;
            while (at < used && sums[at].first != piece) ++at;
            if (at == used) sums[used++] = {piece, 0};
            sums[at].second += value;
        }
        for (std::size_t at = 0; at < used; ++at) {
            const auto& [piece, value] = sums[at];
            if (value != 0) blocks[piece] += value * value * block;
        }
    });
    return blocks;
}

}  // namespace

CoarseLevels::CoarseLevels(const Energy& energy) : threads_(energy.threads()) {
    constexpr std::size_t kFewest = 8;  // pieces; a coarser level would add nothing
    std::vector<std::uint32_t> below(energy.size());
    std::iota(below.begin(), below.end(), 0U);
    std::size_t belowCount = energy.size();
    for (int level = 1; belowCount > kFewest; ++level) {
        std::size_t count = 0;
        std::vector<std::uint32_t> pieces = findPieces(energy.surface(), level, count);
        if (count == belowCount) break;
        addLevel(energy, below, pieces, count);
        below = std::move(pieces);
        belowCount = count;
    }
}

void CoarseLevels::addLevel(const Energy& energy, const std::vector<std::uint32_t>& below,
                            const std::vector<std::uint32_t>& pieces, std::size_t pieceCount) {
    const std::size_t belowCount = levels_.empty() ? below.size() : levels_.back().inverse.size();
    Level level;
    level.parent.resize(belowCount);
    for (std::size_t i = 0; i < pieces.size(); ++i) level.parent[below[i]] = pieces[i];
    level.start.assign(pieceCount + 1, 0);
    for (const std::uint32_t piece : level.parent) ++level.start[piece + 1];
    std::partial_sum(level.start.begin(), level.start.end(), level.start.begin());
    level.members.resize(belowCount);
    std::vector<std::uint32_t> next(level.start.begin(), level.start.end() - 1);
    for (std::uint32_t i = 0; i < belowCount; ++i) level.members[next[level.parent[i]]++] = i;
    level.inverse = pieceBlocks(energy, pieces, pieceCount);
    for (Mat3d& block : level.inverse) block = block.inverse().eval();
    level.correction.resize(pieceCount);
    levels_.push_back(std::move(level));
}

void CoarseLevels::add(const PointelVectors& r, PointelVectors& z) {
    // Up: sums of r over the pieces. Each level's sums stand in `correction` until it comes down.
    const std::vector<Vec3d>* below = &r.raw();
    for (Level& level : levels_) {
        parallelBlocks(level.inverse.size(), kBlock, threads_,
                       [&](std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i) {
                               Vec3d sum = Vec3d::Zero();
                               for (std::uint32_t m = level.start[i]; m < level.start[i + 1]; ++m)
                                   sum += (*below)[level.members[m]];
                               level.correction[i] = sum;
                           }
                       });
        below = &level.correction;
    }
    // Down: the correction of a piece is its own and that of the piece it belongs to.
    for (std::size_t l = levels_.size(); l-- > 0;) {
        Level& level = levels_[l];
        const Level* above = l + 1 < levels_.size() ? &levels_[l + 1] : nullptr;
        parallelBlocks(level.inverse.size(), kBlock, threads_,
                       [&](std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i) {
                               Vec3d& c = level.correction[i];
                               c = level.inverse[i] * c;
                               if (above != nullptr) c += above->correction[above->parent[i]];
                           }
                       });
    }
    if (levels_.empty()) return;
    const Level& finest = levels_.front();
    parallelBlocks(z.size(), kBlock, threads_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) z.raw()[i] += finest.correction[finest.parent[i]];
    });
}

}  // namespace rivage::core
