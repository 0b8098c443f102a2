#include "core/mesh/inverted.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/base/parallel.h"
#include "core/mesh/crossing.h"
#include "core/surface/incident_corners.h"

namespace rivage::core {
namespace {

constexpr double kMinArea = 0.02;     // of the area on the lattice
constexpr double kOpenCorner = 0.05;  // of the area on the lattice: edge by edge, at a corner
constexpr double kOpenCosine = 0.1;   // between the normals of two corners
constexpr double kShrink = 0.7;       // of a displacement, a round
constexpr double kSnap = 1e-3;        // voxels: a displacement below it ends, so rounds are bounded
using Flags = IdVector<PointelId, std::uint8_t>;  // a byte each, so that threads write apart

enum class FaceState : std::uint8_t { open, narrow, inverted };

/// Narrow: not inverted, but a piece at one of its corners would be, or nearly so.
FaceState stateOf(const DigitalSurface& surface, SurfelId s,
                  const IdVector<PointelId, Vec3d>& positions) {
    std::array<Vec3d, 4> at;
    for (std::size_t k = 0; k < 4; ++k) at[k] = positions[surface.corners[s][k]];
    const double whole = surface.faceArea(surface.axis[s]);
    const double area = 0.5 * (at[2] - at[0]).cross(at[3] - at[1]).norm();
    if (!(area >= kMinArea * whole)) return FaceState::inverted;  // also if it is not a number
    std::array<Vec3d, 4> normals;
    std::array<double, 4> sizes;
    for (std::size_t k = 0; k < 4; ++k) {
        normals[k] = (at[(k + 1) & 3U] - at[k]).cross(at[(k + 3) & 3U] - at[k]);
        sizes[k] = normals[k].norm();
    }
    bool narrow = *std::min_element(sizes.begin(), sizes.end()) < kOpenCorner * whole;
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = k + 1; l < 4; ++l) {
            const double dot = normals[k].dot(normals[l]);
            if (!(dot >= 0)) return FaceState::inverted;
            narrow = narrow || dot < kOpenCosine * sizes[k] * sizes[l];
        }
    return narrow ? FaceState::narrow : FaceState::open;
}

bool isInverted(const DigitalSurface& surface, SurfelId s,
                const IdVector<PointelId, Vec3d>& positions) {
    return stateOf(surface, s, positions) == FaceState::inverted;
}

bool anyMoved(const DigitalSurface& surface, SurfelId s, const Flags& moved) {
    const auto& corners = surface.corners[s];
    return std::any_of(corners.begin(), corners.end(), [&](PointelId p) { return moved[p] != 0; });
}

// Finds again and again what is tangled; looks only at what moved since it last looked.
class TangleFinder {
public:
    TangleFinder(const DigitalSurface& surface, const IdVector<PointelId, Vec3d>* home,
                 const RunContext& run)
        : surface_(surface),
          home_(home),
          run_(run),
          touching_(touchingFaces(surface, run)),
          inverted_(surface.surfelCount()),
          crossing_(touching_.size()) {}

    void look(const IdVector<PointelId, Vec3d>& positions, const Flags& moved) {
        forEach(surface_.surfelCount(), [&](std::size_t i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            inverted_[i] = anyMoved(surface_, s, moved) && isInverted(surface_, s, positions);
        });
        forEach(touching_.size(), [&](std::size_t i) {
            const auto& [s, t] = touching_[i];
            crossing_[i] = (anyMoved(surface_, s, moved) || anyMoved(surface_, t, moved)) &&
                           facesCross(surface_, positions, touching_[i]);
        });
    }
    [[nodiscard]] Vec3d homeOf(PointelId p) const {
        return home_ != nullptr ? (*home_)[p] : surface_.position(p);
    }
    [[nodiscard]] const std::vector<FacePair>& touching() const { return touching_; }
    [[nodiscard]] Tangles count() const { return {sum(inverted_), sum(crossing_)}; }
    /// Sets the flags of the pointels that are to be drawn back, and clears the others.
    void choose(const IdVector<PointelId, Vec3d>& positions, Flags& chosen) const {
        std::fill(chosen.begin(), chosen.end(), std::uint8_t{0});
        serialFor(inverted_.size(), run_, [&](std::size_t i) {
            if (inverted_[i] != 0) chooseAll(SurfelId{static_cast<std::uint32_t>(i)}, chosen);
        });
        serialFor(touching_.size(), run_, [&](std::size_t i) {
            if (crossing_[i] != 0) choosePair(touching_[i], positions, chosen);
        });
    }

private:
    template <typename Body>
    void forEach(std::size_t count, const Body& body) const {
        parallelBlocks(count, 4096, run_, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) body(i);
        });
    }
    static std::size_t sum(const std::vector<std::uint8_t>& flags) {
        return static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 1));
    }
    void chooseAll(SurfelId s, Flags& chosen) const {
        for (const PointelId p : surface_.corners[s]) chosen[p] = 1;
    }
    // The copies that the two faces have of one pointel; all corners where these are at home.
    void choosePair(const FacePair& pair, const IdVector<PointelId, Vec3d>& positions,
                    Flags& chosen) const {
        bool away = false;
        for (const PointelId p : surface_.corners[pair.first])
            for (const PointelId q : surface_.corners[pair.second]) {
                if (surface_.pointels[p] != surface_.pointels[q]) continue;
                for (const PointelId copy : {p, q}) {
                    if (positions[copy] == homeOf(copy)) continue;
                    away = true;
                    chosen[copy] = 1;
                }
            }
        if (away) return;
        chooseAll(pair.first, chosen);
        chooseAll(pair.second, chosen);
    }

    const DigitalSurface& surface_;
    const IdVector<PointelId, Vec3d>* home_;
    const RunContext& run_;
    std::vector<FacePair> touching_;
    std::vector<std::uint8_t> inverted_;
    std::vector<std::uint8_t> crossing_;
};

Vec3d drawnBack(const Vec3d& position, const Vec3d& rest) {
    const Vec3d displacement = kShrink * (position - rest);
    const bool ends = !displacement.allFinite() || displacement.cwiseAbs().maxCoeff() < kSnap;
    return ends ? rest : Vec3d(rest + displacement);
}

/// Lets vertices go again where they were before they were drawn back, as far as nothing tangles.
/// Most were drawn back together with a neighbour, and more than was needed.
class GivingBack {
public:
    GivingBack(const DigitalSurface& surface, const std::vector<FacePair>& touching,
               const RunContext& run)
        : surface_(surface), run_(run), around_(incidentCorners(surface, run)) {
        for (const FacePair& pair : touching) {
            pairs_.push_back({pair.first, pair.second});
            pairs_.push_back({pair.second, pair.first});
        }
        std::sort(pairs_.begin(), pairs_.end());
    }

    /// In the order of the pointels, one after the other: each sees what those before it did.
    void run(const IdVector<PointelId, Vec3d>& wanted, IdVector<PointelId, Vec3d>& positions) {
        std::vector<PointelId> drawn;
        serialFor(positions.size(), run_, [&](std::size_t i) {
            const PointelId p{static_cast<std::uint32_t>(i)};
            if (wanted[p].allFinite() && positions[p] != wanted[p]) drawn.push_back(p);
        });
        bool any = true;
        for (int sweep = 0; sweep < kSweeps && any && !run_.stopped(); ++sweep) {
            any = false;
            serialFor(
                drawn.size(), run_,
                [&](std::size_t i) { any = advance(drawn[i], wanted[drawn[i]], positions) || any; },
                kPoll);
        }
    }

private:
    static constexpr int kSweeps = 30;
    static constexpr std::size_t kPoll = 256;  // vertices between two polls
    /// @return whether it moved by as much as is seen
    bool advance(PointelId p, const Vec3d& wanted, IdVector<PointelId, Vec3d>& positions) const {
        const Vec3d now = positions[p];
        const std::size_t before = tangles(p, positions);
        const double whole = (wanted - now).cwiseAbs().maxCoeff();
        for (double share = 1; share * whole > kSnap; share /= 2) {
            positions[p] = share == 1 ? wanted : Vec3d(now + share * (wanted - now));
            if (tangles(p, positions) <= before) return true;
        }
        positions[p] = now;
        return false;
    }
    /// How bad it is around a pointel; a tangle counts more than all narrow faces.
    [[nodiscard]] std::size_t tangles(PointelId p,
                                      const IdVector<PointelId, Vec3d>& positions) const {
        constexpr std::size_t kTangle = 1000;
        std::size_t count = 0;
        for (const std::uint32_t corner : around_.of(p)) {
            const SurfelId s{corner / 4};
            const FaceState state = stateOf(surface_, s, positions);
            count += state == FaceState::inverted ? kTangle : state == FaceState::narrow ? 1 : 0;
            const FacePair first{s, SurfelId{0}};
            for (auto pair = std::lower_bound(pairs_.begin(), pairs_.end(), first);
                 pair != pairs_.end() && pair->first == s; ++pair)
                count += facesCross(surface_, positions, *pair) ? kTangle : 0;
        }
        return count;
    }

    const DigitalSurface& surface_;
    const RunContext& run_;
    IncidentCorners around_;
    std::vector<FacePair> pairs_;  ///< each both ways round, sorted
};

}  // namespace

std::vector<SurfelId> invertedFaces(const DigitalSurface& surface,
                                    const IdVector<PointelId, Vec3d>& positions,
                                    const RunContext& run) {
    std::vector<SurfelId> found;
    serialFor(surface.surfelCount(), run, [&](std::size_t i) {
        const SurfelId s{static_cast<std::uint32_t>(i)};
        if (isInverted(surface, s, positions)) found.push_back(s);
    });
    return found;
}

Tangles untangle(const DigitalSurface& surface, IdVector<PointelId, Vec3d>& positions,
                 const RunContext& run, const IdVector<PointelId, Vec3d>* home) {
    Flags moved(surface.pointelCount(), 1);
    TangleFinder finder(surface, home, run);
    Tangles atFirst;
    IdVector<PointelId, Vec3d> wanted;
    for (int round = 0; !run.stopped(); ++round) {
        finder.look(positions, moved);
        const Tangles found = finder.count();
        if (round == 0) atFirst = found;
        if (found.inverted + found.crossing == 0) break;
        if (round == 0) wanted = positions;
        finder.choose(positions, moved);
        bool any = false;
        serialFor(surface.pointelCount(), run, [&](std::size_t i) {
            const PointelId p{static_cast<std::uint32_t>(i)};
            if (moved[p] == 0) return;
            const Vec3d back = drawnBack(positions[p], finder.homeOf(p));
            any = any || back != positions[p];
            positions[p] = back;
        });
        if (!any) break;
    }
    if (!wanted.empty()) GivingBack(surface, finder.touching(), run).run(wanted, positions);
    return atFirst;
}

}  // namespace rivage::core
