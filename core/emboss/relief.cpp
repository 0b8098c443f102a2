#include "core/emboss/relief.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

SurfelId surfel(std::size_t i) { return SurfelId{static_cast<std::uint32_t>(i)}; }

/// Sets the heights of all pieces of one surfel.
void setHeights(const EmbossInput& input, const RefinedSurface& refined, const SurfelTile& tile,
                SurfelId parent, Relief& relief) {
    const double out = tile.face.ofOuter ? -1 : 1;
    const Vec3d origin = sceneOrigin(input.grid);
    const std::size_t pieces =
        static_cast<std::size_t>(refined.detail) * static_cast<std::size_t>(refined.detail);
    for (std::size_t i = 0; i < pieces; ++i) {
        const SurfelId s = surfel(index(parent) * pieces + i);
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec3d at = refined.rest[refined.surface.corners[s][k]] + origin;
            relief.heights[s][k] = static_cast<float>(out * tile.heightAt(at));
        }
    }
}

/// The normal of a face with its corners lifted along `normal`, times twice its area.
Vec3d liftedNormal(const std::array<Vec3d, 4>& at, const std::array<float, 4>& heights,
                   const Vec3d& normal) {
    const double even = static_cast<double>(heights[2]) - static_cast<double>(heights[0]);
    const double odd = static_cast<double>(heights[3]) - static_cast<double>(heights[1]);
    return (at[2] - at[0] + even * normal).cross(at[3] - at[1] + odd * normal);
}

/// The room of a pointel with a tile of this range around it.
Room roomAt(const Vec3d& offset, double range, const std::optional<Vec3d>& limit) {
    Room room{Vec3d::Constant(-range), Vec3d::Constant(range)};
    if (!limit) return room;
    room.low = room.low.cwiseMax(-*limit - offset).cwiseMin(0);
    room.high = room.high.cwiseMin(*limit - offset).cwiseMax(0);
    return room;
}

}  // namespace

Relief makeRelief(const EmbossInput& input, const RefinedSurface& refined,
                  const IdVector<SurfelId, SurfelTile>& tiles, std::size_t rules,
                  std::optional<double> limit, const RunContext& run) {
    const DigitalSurface& surface = refined.surface;
    Relief relief;
    relief.heights.resize(surface.surfelCount(), {});
    relief.surfelsOfRule.resize(rules);
    (void)parallelFor(
        tiles.size(), run,
        [&](std::size_t n) {
            const SurfelTile& tile = tiles[surfel(n)];
            if (tile.face.tile) setHeights(input, refined, tile, surfel(n), relief);
        },
        256);
    IdVector<PointelId, float> range(surface.pointelCount());
    serialFor(surface.surfelCount(), run, [&](std::size_t n) {
        const FaceTile& face = tiles[refined.parent(surfel(n))].face;
        if (!face.tile) return;
        for (const PointelId p : surface.corners[surfel(n)])
            range[p] = std::max(range[p], static_cast<float>(face.tile->range()));
    });
    serialFor(tiles.size(), run, [&](std::size_t n) {
        const FaceTile& face = tiles[surfel(n)].face;
        if (face.tile) ++relief.surfelsOfRule[face.rule];
    });
    std::optional<Vec3d> sides;
    if (limit) sides = *limit * input.surface.spacing;
    relief.rooms.resize(surface.pointelCount());
    (void)parallelFor(surface.pointelCount(), run, [&](std::size_t n) {
        const PointelId p{static_cast<std::uint32_t>(n)};
        relief.rooms[p] = roomAt(refined.rest[p] - surface.position(p), range[p], sides);
    });
    return relief;
}

PieceNormals pieceNormals(const RefinedSurface& refined, const Relief& relief,
                          const RunContext& run) {
    const DigitalSurface& surface = refined.surface;
    PieceNormals normals{NormalField(surface.surfelCount()), NormalField(surface.surfelCount())};
    (void)parallelFor(surface.surfelCount(), run, [&](std::size_t n) {
        const SurfelId s = surfel(n);
        std::array<Vec3d, 4> at;
        for (std::size_t k = 0; k < 4; ++k) at[k] = refined.rest[surface.corners[s][k]];
        const double vanishing = 1e-6 * surface.faceArea(surface.axis[s]);
        const Vec3d area = (at[2] - at[0]).cross(at[3] - at[1]);
        const bool flat = !(area.norm() > vanishing);  // no direction of its own
        normals.rest[s] = flat ? surface.trivialNormal(s).cast<double>() : area.normalized();
        const Vec3d lifted = liftedNormal(at, relief.heights[s], normals.rest[s]);
        const bool level = flat || relief.heights[s] == std::array<float, 4>{};
        normals.wanted[s] = level ? normals.rest[s] : lifted.normalized();
    });
    return normals;
}

PointelVectors displaced(const RefinedSurface& refined, const Relief& relief,
                         const NormalField& normals, const RunContext& run) {
    constexpr double kSharpest = 0.25;  // of |m|^2: the mitre of sharper creases is cut
    const DigitalSurface& surface = refined.surface;
    struct Sum {
        Vec3d normal = Vec3d::Zero();
        double height = 0;
        double count = 0;
    };
    IdVector<PointelId, Sum> sums(surface.pointelCount());
    serialFor(surface.surfelCount(), run, [&](std::size_t n) {
        const SurfelId s = surfel(n);
        for (std::size_t k = 0; k < 4; ++k) {
            Sum& sum = sums[surface.corners[s][k]];
            sum.normal += normals[s];
            sum.height += static_cast<double>(relief.heights[s][k]);
            sum.count += 1;
        }
    });
    PointelVectors positions = refined.rest;
    (void)parallelFor(surface.pointelCount(), run, [&](std::size_t n) {
        const PointelId p{static_cast<std::uint32_t>(n)};
        const Sum& sum = sums[p];
        if (sum.height == 0) return;
        const Vec3d mean = sum.normal / sum.count;
        const double shortening = std::max(mean.squaredNorm(), kSharpest);
        const Vec3d d = sum.height / sum.count / shortening * mean;
        const Room& room = relief.rooms[p];
        positions[p] += d.cwiseMin(room.high).cwiseMax(room.low);
    });
    return positions;
}

}  // namespace rivage::core
