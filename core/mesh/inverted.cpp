#include "core/mesh/inverted.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr double kMinArea = 0.02;  // voxel^2
constexpr double kShrink = 0.7;    // of a displacement, a round
constexpr double kSnap = 1e-3;     // voxels: a displacement below it ends, so rounds are bounded

bool isInverted(const std::array<PointelId, 4>& corners,
                const IdVector<PointelId, Vec3d>& positions) {
    std::array<Vec3d, 4> at;
    for (std::size_t k = 0; k < 4; ++k) at[k] = positions[corners[k]];
    const double area = 0.5 * (at[2] - at[0]).cross(at[3] - at[1]).norm();
    if (!(area >= kMinArea)) return true;  // also where something is not a number
    std::array<Vec3d, 4> normals;
    for (std::size_t k = 0; k < 4; ++k)
        normals[k] = (at[(k + 1) & 3U] - at[k]).cross(at[(k + 3) & 3U] - at[k]);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = k + 1; l < 4; ++l)
            if (!(normals[k].dot(normals[l]) >= 0)) return true;
    return false;
}

// Flags, a byte each, so that threads write apart; a face none of whose corners moved keeps its
// flag off.
void findInverted(const DigitalSurface& surface, const IdVector<PointelId, Vec3d>& positions,
                  const IdVector<PointelId, std::uint8_t>& moved, int threads,
                  IdVector<SurfelId, std::uint8_t>& inverted) {
    parallelBlocks(surface.surfelCount(), 4096, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const SurfelId s{static_cast<std::uint32_t>(i)};
            const auto& corners = surface.corners[s];
            const bool candidate = (moved[corners[0]] | moved[corners[1]] | moved[corners[2]] |
                                    moved[corners[3]]) != 0;
            inverted[s] = candidate && isInverted(corners, positions) ? 1 : 0;
        }
    });
}

Vec3d drawnBack(const Vec3d& position, const Vec3d& rest) {
    const Vec3d displacement = kShrink * (position - rest);
    const bool ends = !displacement.allFinite() || displacement.cwiseAbs().maxCoeff() < kSnap;
    return ends ? rest : Vec3d(rest + displacement);
}

}  // namespace

std::vector<SurfelId> invertedFaces(const DigitalSurface& surface,
                                    const IdVector<PointelId, Vec3d>& positions) {
    std::vector<SurfelId> found;
    for (std::uint32_t i = 0; i < surface.surfelCount(); ++i)
        if (isInverted(surface.corners[SurfelId{i}], positions)) found.push_back(SurfelId{i});
    return found;
}

std::size_t untangle(const DigitalSurface& surface, IdVector<PointelId, Vec3d>& positions,
                     const RunContext& run) {
    IdVector<PointelId, std::uint8_t> moved(surface.pointelCount(), 1);
    IdVector<SurfelId, std::uint8_t> inverted(surface.surfelCount());
    std::size_t atFirst = 0;
    for (int round = 0; !run.stopped(); ++round) {
        findInverted(surface, positions, moved, run.threads, inverted);
        std::fill(moved.begin(), moved.end(), std::uint8_t{0});
        std::size_t count = 0;
        for (std::uint32_t i = 0; i < surface.surfelCount(); ++i) {
            if (inverted[SurfelId{i}] == 0) continue;
            ++count;
            for (const PointelId p : surface.corners[SurfelId{i}]) moved[p] = 1;
        }
        if (round == 0) atFirst = count;
        if (count == 0) break;
        for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) {
            const PointelId p{i};
            if (moved[p] != 0)
                positions[p] = drawnBack(positions[p], surface.pointels[p].cast<double>());
        }
    }
    return atFirst;
}

}  // namespace rivage::core
