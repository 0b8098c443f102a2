#include "core/normals/smooth_normals.h"

#include <algorithm>
#include <array>

#include "core/normals/disc.h"
#include "core/normals/noise_level.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {
namespace {

/// Whether a disc speaks for the surfel at its centre: on a smooth surface no surfel faces away
/// from the normal, but next to the root of a thin part most of the disc may lie on the thick one.
bool speaksFor(const Disc& disc, const Vec3d& trivial) {
    constexpr double kAway = -0.05;  // below 0 for the risers of nearly flat slopes
    return disc.coherent() && disc.normal.dot(trivial) > kAway;
}

/// The normal of the largest disc below a radius that speaks for the surfel, the trivial one if
/// there is none.
Vec3d narrowNormal(const DigitalSurface& surface, PatchWalker& walker, SurfelId s, double below) {
    constexpr std::array kRadii{1.5, 2.0, 3.0, 4.0};
    const Vec3d trivial = surface.trivialNormal(s).cast<double>();
    Vec3d normal = trivial;
    walkDiscs(surface, walker, s, kRadii, [&](std::size_t scale, const Disc& disc) {
        if (kRadii[scale] >= below) return false;
        if (speaksFor(disc, trivial)) normal = disc.normal;
        return true;
    });
    return normal;
}

}  // namespace

Result<SmoothNormals> smoothNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                    double radius, const RunContext& run) {
    constexpr double kFlatnessRadius = 4;
    const std::array radii{std::min(kFlatnessRadius, radius), std::max(kFlatnessRadius, radius)};
    SmoothNormals result;
    result.normals.resize(surface.surfelCount());
    result.flatness.resize(surface.surfelCount());
    result.density.resize(surface.surfelCount());
    const auto standouts = findStandouts(surface, links, run);
    const auto measure = [&](SurfelId s, PatchWalker& walker) {
        const Vec3d trivial = surface.trivialNormal(s).cast<double>();
        DiscSums sums;
        int standing = 0;
        int all = 0;
        Disc window;
        walker.walkScales(
            s, radii,
            [&](SurfelId g, const Vec3d& offset, double distance) {
                sums.add(surface, g, offset, distance);
                standing += standouts[g];
                ++all;
            },
            [&](std::size_t scale) {
                const Disc disc = sums.disc(surface, radii[scale], trivial);
                if (radii[scale] == kFlatnessRadius)
                    result.flatness[s] = disc.coherent()
                                             ? std::min(static_cast<float>(disc.flatness), kFold)
                                             : kFold;
                if (radii[scale] == radius) window = disc;
                return true;
            });
        result.normals[s] =
            speaksFor(window, trivial) ? window.normal : narrowNormal(surface, walker, s, radius);
        result.density[s] = static_cast<float>(standing) / static_cast<float>(all);
    };
    if (!forEachSurfel(surface, links, run, measure)) return fail(run.stopError());
    return result;
}

}  // namespace rivage::core
