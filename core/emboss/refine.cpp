#include "core/emboss/refine.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/parallel.h"
#include "core/emboss/linels.h"
#include "core/emboss/numbering.h"

namespace rivage::core {
namespace {

PointelId pointel(std::size_t i) { return PointelId{static_cast<std::uint32_t>(i)}; }
SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

class Refiner {
public:
    Refiner(const DigitalSurface& coarse, const SurfelLinks& links, const PointelVectors& positions,
            int detail, const RunContext& run)
        : coarse_(coarse),
          coarseLinks_(links),
          positions_(positions),
          run_(run),
          detail_(static_cast<std::size_t>(detail)),
          linels_(listLinels(coarse, run)),
          numbers_(coarse, linels_, detail) {
        result_.detail = detail;
        result_.surface.spacing = coarse.spacing / detail;
    }

    [[nodiscard]] std::size_t pointelCount() const { return numbers_.count(); }
    Result<RefinedSurface> take() {
        if (placePointels() && joinAlongLinels() && fillSurfels() && groupPieces() && linkPieces())
            return std::move(result_);
        return fail(run_.stopError());
    }

private:
    /// Calls `visit(number, place, position, fixed axes)` for every point that belongs to a
    /// pointel, a linel or a surfel, in parallel.
    template <typename Visit>
    bool forEachPoint(const Visit& visit) const;
    bool placePointels();
    bool joinAlongLinels();
    bool fillSurfels();
    bool groupPieces();
    bool linkPieces();
    void fillPieces(SurfelId s);
    void joinInside(SurfelId s);
    void join(PointelId low, PointelId high, int axis, bool junction);
    [[nodiscard]] SurfelId pieceAt(SurfelId s, std::size_t edge, std::size_t at) const;
    [[nodiscard]] SurfelId acrossEdge(SurfelId s, std::size_t edge, std::size_t at) const;
    [[nodiscard]] std::uint8_t fixedAxes(std::initializer_list<PointelId> corners) const;
    [[nodiscard]] int axisOf(SurfelId s, std::size_t edge) const {
        return linels_.items[linels_.of[s][edge]].axis;
    }
    [[nodiscard]] SurfelId piece(SurfelId s, std::size_t i, std::size_t j) const {
        return surfel((index(s) * detail_ + j) * detail_ + i);
    }

    const DigitalSurface& coarse_;
    const SurfelLinks& coarseLinks_;
    const PointelVectors& positions_;
    const RunContext& run_;
    std::size_t detail_;
    Linels linels_;
    Numbering numbers_;
    RefinedSurface result_;
};

std::uint8_t Refiner::fixedAxes(std::initializer_list<PointelId> corners) const {
    std::uint8_t axes = coarse_.fixedAxes.empty() ? 0 : 7;
    if (axes != 0)
        for (const PointelId p : corners) axes &= coarse_.fixedAxes[p];
    return axes;
}

template <typename Visit>
bool Refiner::forEachPoint(const Visit& visit) const {
    const double k = static_cast<double>(detail_);
    const int fine = static_cast<int>(detail_);
    const auto ofPointel = [&](std::size_t n) {
        const PointelId p = pointel(n);
        visit(n, Vec3i(fine * coarse_.pointels[p]), positions_[p], fixedAxes({p}));
    };
    const auto ofLinel = [&](std::size_t l) {
        const Linel& linel = linels_.items[l];
        const unsigned fixed = fixedAxes({linel.low, linel.high}) & ~(1U << linel.axis);
        for (std::size_t t = 1; t < detail_; ++t) {
            const double at = static_cast<double>(t);
            const Vec3i place =
                fine * coarse_.pointels[linel.low] + static_cast<int>(t) * Vec3i::Unit(linel.axis);
            const Vec3d position =
                (positions_[linel.low] * (k - at) + positions_[linel.high] * at) / k;
            visit(numbers_.onLinel(l, t), place, position, static_cast<std::uint8_t>(fixed));
        }
    };
    const auto ofSurfel = [&](std::size_t n) {
        const SurfelId s = surfel(n);
        const auto& c = coarse_.corners[s];
        const unsigned fixed = fixedAxes({c[0], c[1], c[2], c[3]}) & 1U << coarse_.axis[s];
        const Vec3i alongI = Vec3i::Unit(axisOf(s, 0));
        const Vec3i alongJ = Vec3i::Unit(axisOf(s, 3));
        for (std::size_t j = 1; j < detail_; ++j)
            for (std::size_t i = 1; i < detail_; ++i) {
                const double u = static_cast<double>(i);
                const double v = static_cast<double>(j);
                const Vec3d low = positions_[c[0]] * (k - u) + positions_[c[1]] * u;
                const Vec3d high = positions_[c[3]] * (k - u) + positions_[c[2]] * u;
                const Vec3i place = fine * coarse_.pointels[c[0]] + static_cast<int>(i) * alongI +
                                    static_cast<int>(j) * alongJ;
                visit(numbers_.onSurfel(s, i, j), place,
                      Vec3d((low * (k - v) + high * v) / (k * k)),
                      static_cast<std::uint8_t>(fixed));
            }
    };
    return parallelFor(coarse_.pointelCount(), run_, ofPointel) &&
           parallelFor(linels_.items.size(), run_, ofLinel) &&
           parallelFor(coarse_.surfelCount(), run_, ofSurfel);
}

bool Refiner::placePointels() {
    std::vector<Vec3i> places(pointelCount());
    const bool placed = forEachPoint([&](std::size_t number, const Vec3i& place, const Vec3d&,
                                         std::uint8_t) { places[number] = place; });
    if (!placed || !numbers_.finish(places, run_)) return false;
    DigitalSurface& surface = result_.surface;
    surface.pointels.resize(pointelCount(), Vec3i::Zero());
    result_.rest.resize(pointelCount());
    if (!coarse_.fixedAxes.empty()) surface.fixedAxes.resize(pointelCount());
    return forEachPoint(
        [&](std::size_t number, const Vec3i& place, const Vec3d& position, std::uint8_t fixed) {
            const PointelId p = numbers_.id(number);
            surface.pointels[p] = place;
            result_.rest[p] = position;
            if (!surface.fixedAxes.empty()) surface.fixedAxes[p] = fixed;
        });
}

void Refiner::join(PointelId low, PointelId high, int axis, bool junction) {
    DigitalSurface& surface = result_.surface;
    surface.neighbours[low][2 * axis + 1] = high;
    surface.neighbours[high][2 * axis] = low;
    if (!junction) return;
    surface.junctionSlots[low] |= static_cast<std::uint8_t>(1U << (2 * axis + 1));
    surface.junctionSlots[high] |= static_cast<std::uint8_t>(1U << (2 * axis));
}

// Where sheets part at an end of a linel, its pointel has no neighbour there, see `splitUmbrellas`.
// In one thread: pointels at the ends of several linels gather bits from all of them.
bool Refiner::joinAlongLinels() {
    std::array<PointelId, kSlots> none;
    none.fill(kNone<PointelId>);
    result_.surface.neighbours.resize(pointelCount(), none);
    result_.surface.junctionSlots.resize(pointelCount());
    return serialFor(linels_.items.size(), run_, [&](std::size_t l) {
        const Linel& linel = linels_.items[l];
        const int slot = 2 * linel.axis + 1;
        const bool junction = coarse_.neighbours[linel.low][slot] == linel.high &&
                              (coarse_.junctionSlots[linel.low] >> slot & 1) != 0;
        for (std::size_t t = 0; t < detail_; ++t) {
            if (t == 0 && !linel.aloneAtLow) continue;
            if (t + 1 == detail_ && !linel.aloneAtHigh) continue;
            join(numbers_.id(numbers_.onLinel(l, t)), numbers_.id(numbers_.onLinel(l, t + 1)),
                 linel.axis, junction);
        }
    });
}

void Refiner::joinInside(SurfelId s) {
    const auto at = [&](std::size_t i, std::size_t j) {
        return numbers_.id(numbers_.onSurfel(s, i, j));
    };
    for (std::size_t line = 1; line < detail_; ++line)
        for (std::size_t t = 0; t < detail_; ++t) {
            join(at(t, line), at(t + 1, line), axisOf(s, 0), false);
            join(at(line, t), at(line, t + 1), axisOf(s, 3), false);
        }
}

void Refiner::fillPieces(SurfelId s) {
    DigitalSurface& surface = result_.surface;
    const auto at = [&](std::size_t i, std::size_t j) {
        return numbers_.id(numbers_.onSurfel(s, i, j));
    };
    for (std::size_t j = 0; j < detail_; ++j)
        for (std::size_t i = 0; i < detail_; ++i) {
            const SurfelId p = piece(s, i, j);
            surface.corners[p] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
            surface.axis[p] = coarse_.axis[s];
            surface.innerIsLow[p] = coarse_.innerIsLow[s];
            surface.innerMaterial[p] = coarse_.innerMaterial[s];
            surface.outerMaterial[p] = coarse_.outerMaterial[s];
            surface.interfaceOf[p] = coarse_.interfaceOf[s];
        }
}

bool Refiner::fillSurfels() {
    result_.surface.resizeSurfels(coarse_.surfelCount() * detail_ * detail_);
    return parallelFor(
        coarse_.surfelCount(), run_,
        [&](std::size_t n) {
            fillPieces(surfel(n));
            // One writer a slot: no two surfels at a linel leave it the same way.
            joinInside(surfel(n));
        },
        64);
}

bool Refiner::groupPieces() {
    DigitalSurface& surface = result_.surface;
    const auto pieces = static_cast<std::uint32_t>(detail_ * detail_);
    surface.interfaces = coarse_.interfaces;
    for (Interface& patch : surface.interfaces) {
        patch.begin *= pieces;
        patch.end *= pieces;
    }
    surface.byInterface.resize(coarse_.byInterface.size() * pieces);
    return parallelFor(coarse_.byInterface.size(), run_, [&](std::size_t n) {
        for (std::uint32_t i = 0; i < pieces; ++i)
            surface.byInterface[n * pieces + i] =
                surfel(index(coarse_.byInterface[n]) * std::size_t{pieces} + i);
    });
}

/// The piece at place `at` along an edge, counted from the first corner's side.
SurfelId Refiner::pieceAt(SurfelId s, std::size_t edge, std::size_t at) const {
    const std::size_t last = detail_ - 1;
    switch (edge) {
        case 0: return piece(s, at, 0);
        case 1: return piece(s, last, at);
        case 2: return piece(s, at, last);
        default: return piece(s, 0, at);
    }
}

SurfelId Refiner::acrossEdge(SurfelId s, std::size_t edge, std::size_t at) const {
    const SurfelId other = coarseLinks_[s][edge];
    if (other == kNone<SurfelId>) return other;
    for (std::size_t e = 0; e < 4; ++e)
        if (coarseLinks_[other][e] == s && linels_.of[other][e] == linels_.of[s][edge])
            return pieceAt(other, e, at);
    return kNone<SurfelId>;
}

bool Refiner::linkPieces() {
    result_.links.resize(result_.surface.surfelCount());
    return parallelFor(
        coarse_.surfelCount(), run_,
        [&](std::size_t n) {
            const SurfelId s = surfel(n);
            for (std::size_t j = 0; j < detail_; ++j)
                for (std::size_t i = 0; i < detail_; ++i)
                    result_.links[piece(s, i, j)] = {
                        j > 0 ? piece(s, i, j - 1) : acrossEdge(s, 0, i),
                        i + 1 < detail_ ? piece(s, i + 1, j) : acrossEdge(s, 1, j),
                        j + 1 < detail_ ? piece(s, i, j + 1) : acrossEdge(s, 2, i),
                        i > 0 ? piece(s, i - 1, j) : acrossEdge(s, 3, j)};
        },
        64);
}

}  // namespace

Result<RefinedSurface> refineSurface(const DigitalSurface& surface, const SurfelLinks& links,
                                     const PointelVectors& positions, int detail,
                                     const RunContext& run) {
    constexpr std::uint64_t kMaxCells = 0xfffffffe;  // the last id means "none"
    const std::uint64_t pieces =
        surface.surfelCount() * static_cast<std::uint64_t>(detail * detail);
    Refiner refiner(surface, links, positions, detail, run);
    if (run.stopped()) return fail(run.stopError());
    const std::uint64_t cells = std::max<std::uint64_t>(pieces, refiner.pointelCount());
    if (cells > kMaxCells)
        return fail(Error{ErrorCode::tooLarge,
                          "the embossed surface has " + std::to_string(cells) + " cells",
                          "/options/emboss_detail", kMaxCells, cells});
    return refiner.take();
}

}  // namespace rivage::core
