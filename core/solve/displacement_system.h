#pragma once

#include <cstddef>

#include "core/base/parallel.h"
#include "core/energy/energy.h"
#include "core/solve/minimize.h"

namespace rivage::core {

/// H d = b for the displacement d = x - p: b is minus half the gradient at p.
class DisplacementSystem {
public:
    explicit DisplacementSystem(const Energy& energy);

    [[nodiscard]] const Energy& energy() const { return energy_; }
    [[nodiscard]] const PointelVectors& rightSide() const { return rightSide_; }
    [[nodiscard]] std::size_t size() const { return energy_.size(); }
    [[nodiscard]] const Workers& workers() const { return energy_.workers(); }
    /// out = H d
    void apply(const PointelVectors& d, PointelVectors& out) { energy_.apply(d, out, scratch_); }
    /// out = H d - b, half the gradient of the energy at p + d
    void gradient(const PointelVectors& d, PointelVectors& out);
    /// p + d
    [[nodiscard]] PointelVectors positions(const PointelVectors& d) const;

    /// Calls `body(i)` for every pointel, in parallel; one writer per element.
    template <typename Body>
    void forEach(Body&& body) const {
        parallelBlocks(size(), kBlock, workers(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                body(PointelId{static_cast<std::uint32_t>(i)});
        });
    }
    /// Sum of `term(i)` over the pointels, the same bits for any number of threads.
    template <typename Value, typename Term>
    [[nodiscard]] Value sum(Value zero, Term&& term) const {
        return blockedSum(
            size(), workers(), zero,
            [&](std::size_t begin, std::size_t end) {
                Value partial = zero;
                for (std::size_t i = begin; i < end; ++i)
                    partial = partial + term(PointelId{static_cast<std::uint32_t>(i)});
                return partial;
            },
            kBlock);
    }

private:
    static constexpr std::size_t kBlock = 4096;

    const Energy& energy_;
    PointelVectors rightSide_;
    Energy::Scratch scratch_;
};

/// Watches the residual of an iterative solver: tells when to stop and reports the progress on a
/// logarithmic scale.
class Convergence {
public:
    Convergence(double initial, const SolveOptions& options, const RunContext& run);

    /// @param residual  norm of the (projected) gradient now
    /// @return true to go on
    bool goOn(double residual, int iterations);
    [[nodiscard]] double relative() const { return relative_; }
    [[nodiscard]] bool reached() const { return relative_ <= options_.tolerance; }

private:
    double initial_;
    double relative_ = 1;
    const SolveOptions& options_;
    const RunContext& run_;
};

}  // namespace rivage::core
