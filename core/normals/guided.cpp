#include "core/normals/guided.h"

#include <algorithm>
#include <cmath>

#include "core/normals/disc.h"
#include "core/normals/surfel_loop.h"

namespace rivage::core {
namespace {

constexpr double kFlat = 1;        // flatness up to which a disc is not worse than any other
constexpr double kWindow = 0.35;   // of the excess over it
constexpr double kIncoherent = 9;  // flatness that stands for a fold or a thin part

}  // namespace

Result<NormalField> guidedNormals(const DigitalSurface& surface, const SurfelLinks& links,
                                  double radius, const RunContext& run) {
    NormalField discs(surface.surfelCount());
    IdVector<SurfelId, double> excess(surface.surfelCount());
    const auto measure = [&](SurfelId s, PatchWalker& walker) {
        walkDiscs(surface, walker, s, std::span(&radius, 1), [&](std::size_t, const Disc& disc) {
            discs[s] = disc.normal;
            excess[s] = std::max(0.0, (disc.coherent() ? disc.flatness : kIncoherent) - kFlat);
            return true;
        });
    };
    if (!forEachSurfel(surface, links, run.part(0, 0.5), measure)) return fail(run.stopError());

    NormalField normals(surface.surfelCount());
    const auto choose = [&](SurfelId s, PatchWalker& walker) {
        double least = kIncoherent;
        walker.walk(s, radius,
                    [&](SurfelId g, const Vec3d&, double) { least = std::min(least, excess[g]); });
        Vec3d sum = Vec3d::Zero();
        walker.walk(s, radius, [&](SurfelId g, const Vec3d&, double distance) {
            const double worse = (excess[g] - least) / kWindow;
            sum += (1 - distance / radius) * std::exp(-worse * worse) * discs[g];
        });
        constexpr double kCancelled = 1e-9;
        normals[s] = sum.norm() > kCancelled ? Vec3d(sum.normalized()) : discs[s];
    };
    if (!forEachSurfel(surface, links, run.part(0.5, 1), choose)) return fail(run.stopError());
    return normals;
}

}  // namespace rivage::core
