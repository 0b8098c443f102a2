#include "core/energy/float_operator.h"

#include <algorithm>
#include <array>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr std::size_t kTile = 512;         // rows; their vectors stay in the first cache
constexpr std::size_t kTilesPerBlock = 4;  // of parallel work
constexpr std::size_t kFacesPerBlock = 2048;

}  // namespace

Symmetric3 inverseOf(const Symmetric3& m) {
    // The cofactors: of the diagonal yy zz - yz^2, ..; beside it yz zx - xy zz, ..
    const Lanes& d = m.diagonal;
    const Lanes& b = m.beside;
    Symmetric3 result;
    result.diagonal = turned(d) * turnedTwice(d) - turned(b) * turned(b);
    result.beside = turned(b) * turnedTwice(b) - b * turnedTwice(d);
    const float determinant =
        d[0] * result.diagonal[0] + b[0] * result.beside[0] + b[2] * result.beside[2];
    const Lanes scale = Lanes{1, 1, 1, 0} / determinant;
    result.diagonal = result.diagonal * scale;
    result.beside = result.beside * scale;
    return result;
}

struct FloatOperator::View {
    const std::array<PointelId, 4>* corners;
    const Float4* normals;
    const Symmetric3* fairness;
    const Group* groups;
    const std::uint32_t* rows;
    const std::uint32_t* entries;
    const Float4* x;
    Float4* faceTerms;
    Float4* fairnessTerms;
    Float4* out;

    // Per surfel t_k = 2 s_k - s_(k-1) - s_(k+1) with s_k = n . x_k at its four corners.
    RIVAGE_INLINE void facePass(std::size_t begin, std::size_t end) const {
        for (std::size_t f = begin; f < end; ++f) {
            const auto& c = corners[f];
            const Lanes a = x[index(c[0])].lanes;
            const Lanes b = x[index(c[1])].lanes;
            const Lanes d = x[index(c[2])].lanes;
            const Lanes e = x[index(c[3])].lanes;
            const Lanes lowAb = __builtin_shufflevector(a, b, 0, 4, 1, 5);
            const Lanes lowDe = __builtin_shufflevector(d, e, 0, 4, 1, 5);
            const Lanes highAb = __builtin_shufflevector(a, b, 2, 6, 3, 7);
            const Lanes highDe = __builtin_shufflevector(d, e, 2, 6, 3, 7);
            const Lanes xs = __builtin_shufflevector(lowAb, lowDe, 0, 1, 4, 5);
            const Lanes ys = __builtin_shufflevector(lowAb, lowDe, 2, 3, 6, 7);
            const Lanes zs = __builtin_shufflevector(highAb, highDe, 0, 1, 4, 5);
            const Lanes n = normals[f].lanes;
            const Lanes s = xs * n[0] + ys * n[1] + zs * n[2];
            const Lanes around = __builtin_shufflevector(s, s, 1, 2, 3, 0) +
                                 __builtin_shufflevector(s, s, 3, 0, 1, 2);
            faceTerms[f].lanes = (s + s) - around;
        }
    }

    // w = (G / d^2) (d x - sum of the d fairness neighbours); out = alpha x + d w.
    RIVAGE_INLINE void fairnessPass(std::size_t firstGroup, std::size_t lastGroup) const {
        for (std::size_t g = firstGroup; g < lastGroup; ++g) {
            const Group& group = groups[g];
            const std::uint32_t* entry = entries + group.entry;
            const std::uint32_t stride = group.means + group.corners + group.uses;
            for (std::uint32_t r = 0; r < group.count; ++r, entry += stride) {
                const std::uint32_t i = rows[group.row + r];
                const Symmetric3 m = fairness[i];
                const Lanes here = x[i].lanes;
                Lanes y = here * m.beside[3];
                for (std::uint32_t k = 0; k < group.means; ++k) y -= x[entry[k]].lanes;
                const Lanes w = product(m, y);
                fairnessTerms[i].lanes = w;
                out[i].lanes = here * m.diagonal[3] + w * m.beside[3];
            }
        }
    }

    // out += sum of n t over the corners here, less w of the rows that this one is a mean of.
    RIVAGE_INLINE void gatherPass(std::size_t firstGroup, std::size_t lastGroup) const {
        const float* terms = reinterpret_cast<const float*>(faceTerms);
        for (std::size_t g = firstGroup; g < lastGroup; ++g) {
            const Group& group = groups[g];
            const std::uint32_t* entry = entries + group.entry + group.means;
            const std::uint32_t stride = group.means + group.corners + group.uses;
            for (std::uint32_t r = 0; r < group.count; ++r, entry += stride) {
                const std::uint32_t i = rows[group.row + r];
                Lanes sum = out[i].lanes;
                for (std::uint32_t k = 0; k < group.corners; ++k)
                    sum += normals[entry[k] >> 2].lanes * terms[entry[k]];
                const std::uint32_t* use = entry + group.corners;
                for (std::uint32_t k = 0; k < group.uses; ++k) sum -= fairnessTerms[use[k]].lanes;
                out[i].lanes = sum;
            }
        }
    }

    void faces(std::size_t begin, std::size_t end) const { facePass(begin, end); }
    void means(std::size_t begin, std::size_t end) const { fairnessPass(begin, end); }
    void gather(std::size_t begin, std::size_t end) const { gatherPass(begin, end); }
#if defined(__x86_64__)
    __attribute__((target("avx2"))) void facesWide(std::size_t begin, std::size_t end) const {
        facePass(begin, end);
    }
    __attribute__((target("avx2"))) void meansWide(std::size_t begin, std::size_t end) const {
        fairnessPass(begin, end);
    }
    __attribute__((target("avx2"))) void gatherWide(std::size_t begin, std::size_t end) const {
        gatherPass(begin, end);
    }
#endif
};

FloatOperator::FloatOperator(const Energy& energy, const RunContext& run, Instructions instructions)
    : workers_(energy.workers()),
      surface_(energy.surface()),
      energy_(energy),
      normals_(surface_.surfelCount()),
      fairness_(energy.size()),
      faceTerms_(surface_.surfelCount()),
      fairnessTerms_(energy.size()) {
#if defined(__x86_64__)
    wide_ = instructions == Instructions::best && __builtin_cpu_supports("avx2");
#endif
    parallelBlocks(normals_.size(), kFacesPerBlock, workers_,
                   [&](std::size_t begin, std::size_t end) {
                       for (std::size_t f = begin; f < end; ++f) {
                           const SurfelId s{static_cast<std::uint32_t>(f)};
                           normals_[s].lanes =
                               lanesOf(std::sqrt(energy.weights().beta[s]) * energy.normals()[s]);
                       }
                   });
    parallelBlocks(
        energy.size(), kFacesPerBlock, workers_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t n = begin; n < end; ++n) {
                const PointelId i{static_cast<std::uint32_t>(n)};
                const int degree = __builtin_popcount(energy.fairnessSlots(i));
                const Mat3d block = energy.fairnessBlock(i) / std::max(1, degree * degree);
                fairness_[i].diagonal = lanesOf(block.diagonal());
                fairness_[i].diagonal[3] = static_cast<float>(energy.weights().alpha[i]);
                fairness_[i].beside = lanesOf({block(0, 1), block(1, 2), block(2, 0)});
                fairness_[i].beside[3] = static_cast<float>(degree);
            }
        });
    if (!run.stopped()) sortRows(energy, run);
}

// Counting sort inside each tile: rows that have as many entries of each kind come together.
void FloatOperator::sortRows(const Energy& energy, const RunContext& run) {
    const std::size_t size = energy.size();
    constexpr std::uint32_t kKinds = 7;          // 0 to 6 neighbours
    constexpr std::uint32_t kKeys = 13 * 7 * 7;  // 0 to 12 corners
    std::array<std::uint32_t, kKeys + 1> at{};
    std::array<std::uint32_t, kTile> keys;
    rows_.resize(size);
    entries_.reserve(size * 12);
    tiles_.assign(1, 0);
    for (std::size_t begin = 0; begin < size && !run.stopped(); begin += kTile) {
        const std::size_t end = std::min(begin + kTile, size);
        at.fill(0);
        for (std::size_t n = begin; n < end; ++n) {
            const PointelId i{static_cast<std::uint32_t>(n)};
            const auto corners = static_cast<std::uint32_t>(energy.incidentCorners(i).size());
            const std::uint32_t means = __builtin_popcount(energy.fairnessSlots(i));
            const std::uint32_t uses = __builtin_popcount(energy.fairnessUses(i));
            keys[n - begin] = (corners * kKinds + means) * kKinds + uses;
            ++at[keys[n - begin] + 1];
        }
        for (std::uint32_t key = 0; key < kKeys; ++key) {
            const std::uint32_t count = at[key + 1];
            at[key + 1] += at[key];
            if (count == 0) continue;
            groups_.push_back({.row = static_cast<std::uint32_t>(begin) + at[key],
                               .count = count,
                               .means = static_cast<std::uint8_t>(key / kKinds % kKinds),
                               .corners = static_cast<std::uint8_t>(key / kKinds / kKinds),
                               .uses = static_cast<std::uint8_t>(key % kKinds)});
        }
        for (std::size_t n = begin; n < end; ++n)
            rows_[begin + at[keys[n - begin]]++] = static_cast<std::uint32_t>(n);
        tiles_.push_back(static_cast<std::uint32_t>(groups_.size()));
    }
    for (Group& group : groups_) {
        if (run.stopped()) {
            // No rows at all: what is left of a stopped solver then touches nothing.
            tiles_.assign(1, 0);
            return;
        }
        group.entry = static_cast<std::uint32_t>(entries_.size());
        for (std::uint32_t r = 0; r < group.count; ++r) {
            const PointelId i{rows_[group.row + r]};
            const auto& neighbours = surface_.neighbours[i];
            for (int slot = 0; slot < kSlots; ++slot)
                if (energy.fairnessSlots(i) >> slot & 1)
                    entries_.push_back(index(neighbours[slot]));
            const auto corners = energy.incidentCorners(i);
            entries_.insert(entries_.end(), corners.begin(), corners.end());
            for (int slot = 0; slot < kSlots; ++slot)
                if (energy.fairnessUses(i) >> slot & 1) entries_.push_back(index(neighbours[slot]));
        }
    }
}

void FloatOperator::apply(const FloatVectors& x, FloatVectors& out) {
    const View view{surface_.corners.raw().data(),
                    normals_.raw().data(),
                    fairness_.raw().data(),
                    groups_.data(),
                    rows_.data(),
                    entries_.data(),
                    x.raw().data(),
                    faceTerms_.data(),
                    fairnessTerms_.data(),
                    out.raw().data()};
    parallelBlocks(faceTerms_.size(), kFacesPerBlock, workers_,
                   [&](std::size_t begin, std::size_t end) {
                       wide_ ? view.facesWide(begin, end) : view.faces(begin, end);
                   });
    const std::size_t tiles = tiles_.size() - 1;
    parallelBlocks(tiles, kTilesPerBlock, workers_, [&](std::size_t begin, std::size_t end) {
        const auto first = tiles_[begin];
        const auto last = tiles_[end];
        wide_ ? view.meansWide(first, last) : view.means(first, last);
    });
    parallelBlocks(tiles, kTilesPerBlock, workers_, [&](std::size_t begin, std::size_t end) {
        const auto first = tiles_[begin];
        const auto last = tiles_[end];
        wide_ ? view.gatherWide(first, last) : view.gather(first, last);
    });
}

IdVector<PointelId, Symmetric3> FloatOperator::diagonalBlocks() const {
    IdVector<PointelId, Symmetric3> blocks(fairness_.size());
    parallelBlocks(blocks.size(), kFacesPerBlock, workers_,
                   [&](std::size_t begin, std::size_t end) {
                       for (std::size_t n = begin; n < end; ++n) {
                           const PointelId i{static_cast<std::uint32_t>(n)};
                           const Symmetric3& fair = fairness_[i];
                           const float squared = fair.beside[3] * fair.beside[3];
                           const float alpha = fair.diagonal[3];
                           Symmetric3 sum{fair.diagonal * squared + alpha, fair.beside * squared};
                           // Two edges of each surfel end at i.
                           for (const std::uint32_t corner : energy_.incidentCorners(i))
                               addSquare(sum, normals_[SurfelId{corner / 4}].lanes, 2);
                           for (int slot = 0; slot < kSlots; ++slot) {
                               if ((energy_.fairnessUses(i) >> slot & 1) == 0) continue;
                               const Symmetric3& use = fairness_[surface_.neighbours[i][slot]];
                               sum.diagonal += use.diagonal;
                               sum.beside += use.beside;
                           }
                           blocks[i] = sum;
                       }
                   });
    return blocks;
}

}  // namespace rivage::core
