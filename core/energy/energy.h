#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/options.h"
#include "core/base/parallel.h"
#include "core/base/report.h"
#include "core/normals/normal_field.h"
#include "core/surface/digital_surface.h"

namespace rivage::core {

/// One 3-vector per pointel: a position, a displacement or a gradient, in voxel units.
using PointelVectors = IdVector<PointelId, Vec3d>;

/// The weights of the energy, one alpha and gamma per pointel and one beta per surfel.
struct EnergyWeights {
    IdVector<PointelId, double> alpha;  ///< > 0
    IdVector<SurfelId, double> beta;    ///< >= 0
    IdVector<PointelId, double> gamma;  ///< >= 0

    /// The same weights everywhere.
    static EnergyWeights uniform(const DigitalSurface& surface, const EnergyOptions& options);
};

/// A surface that has its shape already and is to get relief: the energy then measures from it and
/// not from the lattice, so that it vanishes where the normals are those of the shape.
struct RestShape {
    PointelVectors positions;  ///< voxel units
    NormalField normals;       ///< of its faces, unit
    PointelVectors targets;    ///< what the data term holds on to; as many
    [[nodiscard]] bool any() const { return !positions.empty(); }
};

/// The quadratic energy of all interfaces at once, as a matrix-free operator.
///
///     E(x) = sum_i alpha_i |x_i - p_i|^2
///          + sum_f beta_f sum_{(a,b) edge of f} ((x_a - x_b) . n_f)^2
///          + sum_i (x_i - b_i)^T G_i (x_i - b_i),   b_i = mean of x_j over the fairness neighbours
///
/// `Fairness::umbrella`: G_i = gamma_i I, the energy of the paper. `Fairness::tangential`:
/// G_i = gamma_i T_i^2, where T_i projects softly along the surface, the crease, or to nothing at
/// a corner, so that fairness does not shrink them. Fairness neighbours are all neighbours; with
/// `JunctionFairness::curve` a pointel on a junction curve has only its two neighbours on it.
///
/// With a rest shape, the data term holds on to its targets, and the others count the change since
/// its positions p: edges the change of (x_a - x_b) . n_f from (p_a - p_b) . m_f with m_f its
/// normals, fairness x - p.
///
/// Half the Hessian, H = A + L + B^T G B, is constant, symmetric and positive definite.
/// @source [CGL18] equation (1); METHOD.md 2.2, 2.6, 2.7
class Energy {
public:
    /// @param normals  unit vectors; their sign does not matter
    /// @param workers  for all that the energy does; once they are asked to stop, it gives
    ///                 nothing meaningful any more, and soon
    /// @cost  O(pointels + surfels) time; about 150 bytes per pointel
    Energy(const DigitalSurface& surface, NormalField normals, EnergyWeights weights,
           const EnergyOptions& options, const Workers& workers, RestShape rest = {});

    [[nodiscard]] const DigitalSurface& surface() const { return surface_; }
    [[nodiscard]] const EnergyWeights& weights() const { return weights_; }
    [[nodiscard]] const NormalField& normals() const { return normals_; }
    [[nodiscard]] const EnergyOptions& options() const { return options_; }
    [[nodiscard]] const Workers& workers() const { return workers_; }
    [[nodiscard]] std::size_t size() const { return surface_.pointelCount(); }
    /// Corners k of surfels f at a pointel, as 4 f + k, ascending.
    [[nodiscard]] std::span<const std::uint32_t> incidentCorners(PointelId i) const {
        return {incident_.data() + start_[index(i)], incident_.data() + start_[index(i) + 1]};
    }
    /// Slots of the fairness neighbours, as bits, and of the pointels whose one this is.
    [[nodiscard]] unsigned fairnessSlots(PointelId i) const { return fairnessSlots_[i]; }
    [[nodiscard]] unsigned fairnessUses(PointelId i) const {
        unsigned uses = 0;
        for (int slot = 0; slot < kSlots; ++slot) {
            const PointelId j = surface_.neighbours[i][slot];
            if (j != kNone<PointelId> && isFairnessNeighbour(j, slot ^ 1)) uses |= 1U << slot;
        }
        return uses;
    }
    /// G_i, 0 without fairness neighbours.
    [[nodiscard]] Mat3d fairnessBlock(PointelId i) const;

    /// p: the lattice positions, or those of the rest shape.
    [[nodiscard]] PointelVectors restPositions() const;
    [[nodiscard]] Vec3d restPosition(PointelId i) const {
        return rest_.any() ? rest_.positions[i] : surface_.position(i);
    }
    /// Minus half the gradient at the rest positions.
    [[nodiscard]] PointelVectors restForce() const;
    /// The energy by term.
    [[nodiscard]] EnergyReport value(const PointelVectors& x) const;
    /// out = H x, half the Hessian times x. `scratch` is resized as needed and may be reused.
    struct Scratch {
        std::vector<double> faceTerms;  // 4 per surfel
        PointelVectors fairnessTerms;
    };
    void apply(const PointelVectors& x, PointelVectors& out, Scratch& scratch) const;
    /// The gradient, 2 (H x - A p) without a rest shape.
    [[nodiscard]] PointelVectors gradient(const PointelVectors& x) const;
    /// The 3x3 block of H on the diagonal of each pointel.
    [[nodiscard]] IdVector<PointelId, Mat3d> diagonalBlocks() const;
    /// Scalars m_i with diag(m_i I) >= H: a step of H / m never increases the energy.
    /// @source METHOD.md 2.2 (majoriser); the proof holds for any G_i <= gamma_i I
    [[nodiscard]] IdVector<PointelId, double> majorizer() const;

    /// A pointel and its coefficient in one square of the energy.
    struct Coefficient {
        PointelId pointel;
        double value;
    };
    /// Half the Hessian as a sum of squares, x^T H x = sum_t |sum_i c_ti x_i|^2_(Q_t): calls
    /// `visit(std::span<const Coefficient>, const Mat3d& Q)` once per square, at most 7 pointels.
    template <typename Visit>
    void forEachSquare(Visit&& visit) const;

private:
    [[nodiscard]] bool isFairnessNeighbour(PointelId of, int slot) const {
        return fairnessSlots_[of] >> slot & 1;
    }
    [[nodiscard]] Vec3d fromMean(const PointelVectors& x, PointelId i) const;
    [[nodiscard]] Vec3d applyFairness(PointelId i, const Vec3d& y) const;
    [[nodiscard]] double restRise(SurfelId s, std::size_t k, const Vec3d& normal) const;
    [[nodiscard]] Vec3d shapeForce(PointelId i) const;
    [[nodiscard]] Mat3d alignmentBlock(PointelId i) const;
    [[nodiscard]] bool sharesFaces(PointelId i, PointelId neighbour) const;
    void chooseFairnessNeighbours(JunctionFairness rule);
    void listIncidentCorners();
    void computeTangentialFairness();

    const DigitalSurface& surface_;
    NormalField normals_;
    EnergyWeights weights_;
    EnergyOptions options_;
    Workers workers_;
    RestShape rest_;
    IdVector<PointelId, std::uint8_t> fairnessSlots_;
    IdVector<PointelId, double> inverseDegree_;  // 0 without fairness neighbours
    IdVector<PointelId, Mat3d> tangential_;      // G_i / gamma_i; empty with umbrella fairness
    // Corners k of surfels f at pointel i, as 4 f + k: incident_[start_[i] .. start_[i + 1]).
    std::vector<std::uint32_t> start_;
    std::vector<std::uint32_t> incident_;
};

template <typename Visit>
void Energy::forEachSquare(Visit&& visit) const {
    std::array<Coefficient, kSlots + 1> row;
    const auto give = [&](std::size_t entries, const Mat3d& block) {
        visit(std::span<const Coefficient>(row.data(), entries), block);
    };
    for (std::size_t f = 0; f < surface_.surfelCount(); ++f) {
        const SurfelId s{static_cast<std::uint32_t>(f)};
        const Mat3d block = weights_.beta[s] * normals_[s] * normals_[s].transpose();
        for (int k = 0; k < 4; ++k) {
            row[0] = {surface_.corners[s][k], 1};
            row[1] = {surface_.corners[s][(k + 1) % 4], -1};
            give(2, block);
        }
    }
    for (std::size_t n = 0; n < size(); ++n) {
        const PointelId i{static_cast<std::uint32_t>(n)};
        row[0] = {i, 1};
        give(1, weights_.alpha[i] * Mat3d::Identity());
        if (inverseDegree_[i] == 0) continue;
        std::size_t entries = 1;
        for (int slot = 0; slot < kSlots; ++slot)
            if (isFairnessNeighbour(i, slot))
                row[entries++] = {surface_.neighbours[i][slot], -inverseDegree_[i]};
        give(entries, fairnessBlock(i));
    }
}

}  // namespace rivage::core
