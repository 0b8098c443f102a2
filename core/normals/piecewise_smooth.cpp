#include "core/normals/piecewise_smooth.h"

#include <array>
#include <cmath>
#include <numeric>

#include "core/base/parallel.h"
#include "core/normals/corner_groups.h"

namespace rivage::core {
namespace {

constexpr std::size_t kBlock = 2048;
constexpr double kSolveTolerance = 1e-4;  // of a linear solve, relative to its right-hand side
constexpr int kSolveSteps = 200;
constexpr double kAlternationEnd = 1e-3;  // largest change of v that still counts
constexpr std::array kEpsilons{2.0, 1.0, 0.5, 0.25};
constexpr int kAlternations = 10;

/// Conjugate gradients with a diagonal preconditioner for a symmetric positive definite operator
/// on arrays of `Value` (numbers or vectors).
template <typename Value>
class DiagonalCg {
public:
    DiagonalCg(std::size_t size, const RunContext& run)
        : run_(run), r_(size), z_(size), p_(size), q_(size), diagonal_(size) {}

    [[nodiscard]] std::vector<double>& diagonal() { return diagonal_; }

    /// Improves `x` until the residual is small against that of x = 0.
    /// @param apply  apply(in, out): out = matrix * in
    template <typename Apply>
    void solve(std::vector<Value>& x, const std::vector<Value>& right, Apply&& apply) {
        apply(x, r_);
        forEach([&](std::size_t i) {
            r_[i] = right[i] - r_[i];
            z_[i] = r_[i] / diagonal_[i];
            p_[i] = z_[i];
        });
        const double end = kSolveTolerance * kSolveTolerance * dot(right, right);
        double rz = dot(r_, z_);
        for (int step = 0; step < kSolveSteps && dot(r_, r_) > end && !run_.stopped(); ++step) {
            apply(p_, q_);
            const double length = rz / dot(p_, q_);
            forEach([&](std::size_t i) {
                x[i] += length * p_[i];
                r_[i] -= length * q_[i];
                z_[i] = r_[i] / diagonal_[i];
            });
            const double next = dot(r_, z_);
            const double keep = next / rz;
            rz = next;
            forEach([&](std::size_t i) { p_[i] = z_[i] + keep * p_[i]; });
        }
    }

private:
    static double product(double a, double b) { return a * b; }
    static double product(const Vec3d& a, const Vec3d& b) { return a.dot(b); }

    template <typename Body>
    void forEach(Body&& body) const {
        parallelBlocks(r_.size(), kBlock, run_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(i);
        });
    }
    [[nodiscard]] double dot(const std::vector<Value>& a, const std::vector<Value>& b) const {
        return blockedSum(a.size(), run_, 0.0, [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t i = begin; i < end; ++i) sum += product(a[i], b[i]);
            return sum;
        });
    }

    const RunContext& run_;
    std::vector<Value> r_;
    std::vector<Value> z_;
    std::vector<Value> p_;
    std::vector<Value> q_;
    std::vector<double> diagonal_;
};

class AmbrosioTortorelli {
public:
    AmbrosioTortorelli(const SurfelLinks& links, const NormalField& input, InterfacePointels groups,
                       const PiecewiseSmoothOptions& options, const RunContext& run)
        : links_(links),
          groups_(std::move(groups)),
          options_(options),
          run_(run),
          u_(input.raw()),
          right_(input.size()),
          v_(groups_.count, 1.0),
          weight_(4 * input.size(), 1.0),
          jump_(4 * input.size(), 0.0),
          solveU_(input.size(), run),
          solveV_(groups_.count, run) {
        for (std::size_t f = 0; f < right_.size(); ++f) right_[f] = options_.alpha * u_[f];
    }

    [[nodiscard]] bool minimize() {
        for (std::size_t level = 0; level < kEpsilons.size(); ++level)
            for (int round = 0; round < kAlternations; ++round) {
                run_.report(Stage::normals, (static_cast<double>(level) +
                                             static_cast<double>(round) / kAlternations) /
                                                static_cast<double>(kEpsilons.size()));
                updateNormals();
                const double change = updateFeatures(kEpsilons[level]);
                if (run_.stopped()) return false;
                if (change < kAlternationEnd) break;
            }
        run_.report(Stage::normals, 1);
        return true;
    }

    [[nodiscard]] const std::vector<Vec3d>& normals() const { return u_; }
    [[nodiscard]] bool isFeature(std::size_t f, std::size_t k) const {
        constexpr double kHalf = 0.5;
        return linked(f, k) != kNone<SurfelId> && v_[groups_.of[4 * f + k]] < kHalf &&
               v_[groups_.of[4 * f + ((k + 1) & 3U)]] < kHalf;
    }

private:
    template <typename Body>
    void forEach(std::size_t count, Body&& body) const {
        parallelBlocks(count, kBlock, run_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(i);
        });
    }
    [[nodiscard]] SurfelId linked(std::size_t f, std::size_t k) const {
        return links_[SurfelId{static_cast<std::uint32_t>(f)}][k];
    }

    // [alpha + B^T diag((M v)^2) B] u = alpha g
    void updateNormals() {
        forEach(u_.size(), [&](std::size_t f) {
            double diagonal = options_.alpha;
            for (std::size_t k = 0; k < 4; ++k) {
                if (linked(f, k) == kNone<SurfelId>) continue;
                const double mean =
                    (v_[groups_.of[4 * f + k]] + v_[groups_.of[4 * f + ((k + 1) & 3U)]]) / 2;
                weight_[4 * f + k] = mean * mean;
                diagonal += mean * mean;
            }
            solveU_.diagonal()[f] = diagonal;
        });
        solveU_.solve(u_, right_, [&](const std::vector<Vec3d>& in, std::vector<Vec3d>& out) {
            forEach(in.size(), [&](std::size_t f) {
                Vec3d sum = options_.alpha * in[f];
                for (std::size_t k = 0; k < 4; ++k)
                    if (const SurfelId g = linked(f, k); g != kNone<SurfelId>)
                        sum += weight_[4 * f + k] * (in[f] - in[index(g)]);
                out[f] = sum;
            });
        });
    }

    // Calls `visit(other end, share, squared jump of u)` for the edges at group v. Both faces of a
    // linked edge list it, so each has half a share; an edge without a link is no place of a jump.
    template <typename Visit>
    void forEdgesAt(std::size_t v, Visit&& visit) const {
        for (std::uint32_t at = groups_.start[v]; at < groups_.start[v + 1]; ++at) {
            const std::size_t f = groups_.members[at] / 4;
            const std::size_t k = groups_.members[at] & 3U;
            const std::size_t previous = (k + 3) & 3U;
            visit(groups_.of[4 * f + ((k + 1) & 3U)], linked(f, k) == kNone<SurfelId> ? 1.0 : 0.5,
                  jump_[4 * f + k]);
            visit(groups_.of[4 * f + previous], linked(f, previous) == kNone<SurfelId> ? 1.0 : 0.5,
                  jump_[4 * f + previous]);
        }
    }

    // [lambda / (4 epsilon) + lambda epsilon A^T A + M^T diag(|B u|^2) M] v = lambda / (4 epsilon)
    double updateFeatures(double epsilon) {
        const double pull = options_.lambda / (4 * epsilon);
        const double stiff = options_.lambda * epsilon;
        forEach(u_.size(), [&](std::size_t f) {
            for (std::size_t k = 0; k < 4; ++k)
                if (const SurfelId g = linked(f, k); g != kNone<SurfelId>)
                    jump_[4 * f + k] = (u_[f] - u_[index(g)]).squaredNorm();
        });
        forEach(v_.size(), [&](std::size_t v) {
            double diagonal = pull;
            forEdgesAt(v, [&](std::uint32_t, double share, double jump) {
                diagonal += share * (stiff + jump / 4);
            });
            solveV_.diagonal()[v] = diagonal;
        });
        const std::vector<double> last = v_;
        solveV_.solve(v_, std::vector<double>(v_.size(), pull),
                      [&](const std::vector<double>& in, std::vector<double>& out) {
                          forEach(in.size(), [&](std::size_t v) {
                              double sum = pull * in[v];
                              forEdgesAt(v, [&](std::uint32_t w, double share, double jump) {
                                  sum += share *
                                         (stiff * (in[v] - in[w]) + jump / 4 * (in[v] + in[w]));
                              });
                              out[v] = sum;
                          });
                      });
        double change = 0;
        for (std::size_t v = 0; v < v_.size(); ++v)
            change = std::max(change, std::abs(v_[v] - last[v]));
        return change;
    }

    const SurfelLinks& links_;
    InterfacePointels groups_;
    PiecewiseSmoothOptions options_;
    const RunContext& run_;
    std::vector<Vec3d> u_;
    std::vector<Vec3d> right_;
    std::vector<double> v_;
    std::vector<double> weight_;  // (M v)^2 of each edge of each surfel
    std::vector<double> jump_;    // |B u|^2 of each edge of each surfel, 0 without a link
    DiagonalCg<Vec3d> solveU_;
    DiagonalCg<double> solveV_;
};

}  // namespace

Result<PiecewiseSmoothField> piecewiseSmoothNormals(const DigitalSurface& surface,
                                                    const SurfelLinks& links,
                                                    const NormalField& input,
                                                    const PiecewiseSmoothOptions& options,
                                                    const RunContext& run) {
    AmbrosioTortorelli functional(links, input, groupCorners(surface, links, run), options, run);
    if (run.stopped()) return fail(run.stopError());
    if (!functional.minimize()) return fail(run.stopError());
    PiecewiseSmoothField field{NormalField(input.size()),
                               IdVector<SurfelId, std::uint8_t>(input.size())};
    const bool done = parallelFor(input.size(), run, [&](std::size_t f) {
        const SurfelId s{static_cast<std::uint32_t>(f)};
        const Vec3d& u = functional.normals()[f];
        constexpr double kCancelled = 1e-9;
        field.normals[s] = u.norm() > kCancelled ? Vec3d(u.normalized()) : input[s];
        for (std::size_t k = 0; k < 4; ++k)
            if (functional.isFeature(f, k)) field.features[s] |= static_cast<std::uint8_t>(1U << k);
    });
    if (!done) return fail(run.stopError());
    return field;
}

}  // namespace rivage::core
