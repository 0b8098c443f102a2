#pragma once

#include <cstdint>
#include <vector>

#include "core/base/run_context.h"
#include "core/energy/energy.h"
#include "core/energy/lanes.h"

namespace rivage::core {

/// `Energy::apply` in single precision, about three times as fast: for the inner loops of solvers
/// that measure what they reached in double.
///
/// Three passes, as in `Energy`: per surfel, per pointel its fairness term, per pointel the sum of
/// what meets there. Rows are sorted inside tiles by their numbers of entries, so that
/// the processor can foresee every loop. The passes exist twice, for every processor and for those
/// with AVX2; both compute the same bits, as no product is contracted with a sum.
/// @source SOLVER.md (face-based operator); the order of the rows is ours
class FloatOperator {
public:
    enum class Instructions : std::uint8_t { best, plain };

    /// @cost O(pointels + surfels) time, about 150 bytes a pointel. If `run` asks to stop, the
    ///       operator may have no rows, and `apply` computes nothing.
    FloatOperator(const Energy& energy, const RunContext& run,
                  Instructions instructions = Instructions::best);

    /// out = H x
    void apply(const FloatVectors& x, FloatVectors& out);
    /// The 3x3 block of H on the diagonal of each pointel.
    [[nodiscard]] IdVector<PointelId, Symmetric3> diagonalBlocks() const;
    /// sqrt(beta) n of each surfel.
    [[nodiscard]] const IdVector<SurfelId, Float4>& scaledNormals() const { return normals_; }
    /// Per pointel, with d fairness neighbours: G_i / d^2, alpha_i, and d, in the fourth lanes of
    /// `diagonal` and `beside`.
    [[nodiscard]] const IdVector<PointelId, Symmetric3>& fairness() const { return fairness_; }

private:
    /// Rows of a tile with the same numbers of entries.
    struct Group {
        std::uint32_t row = 0;    // its first one in rows_
        std::uint32_t count = 0;  // rows
        std::uint32_t entry = 0;  // its first one in entries_
        std::uint8_t means = 0;   // fairness neighbours of a row
        std::uint8_t corners = 0;
        std::uint8_t uses = 0;  // rows whose fairness neighbour a row is
    };
    /// What the passes read and write, plain pointers for the kernels.
    struct View;

    void sortRows(const Energy& energy, const RunContext& run);

    Workers workers_;
    bool wide_ = false;
    const DigitalSurface& surface_;
    const Energy& energy_;
    IdVector<SurfelId, Float4> normals_;
    IdVector<PointelId, Symmetric3> fairness_;
    std::vector<Group> groups_;
    std::vector<std::uint32_t> tiles_ = {0};  // groups_[tiles_[t] .. tiles_[t + 1])
    std::vector<std::uint32_t> rows_;         // pointels
    std::vector<std::uint32_t> entries_;      // of a row: its means, corners 4 f + k, uses
    std::vector<Float4> faceTerms_;
    std::vector<Float4> fairnessTerms_;
};

}  // namespace rivage::core
