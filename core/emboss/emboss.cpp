#include "core/emboss/emboss.h"

#include <cmath>

#include "core/base/parallel.h"
#include "core/emboss/relief.h"
#include "core/emboss/tile_choice.h"
#include "core/energy/weights.h"
#include "core/solve/minimize.h"

namespace rivage::core {
namespace {

/// The minimizer of the energy that counts from the refined surface, into `embossed`.
Result<void> alignToTiles(const VoxelGrid& grid, const Relief& relief, PieceNormals normals,
                          const MethodOptions& options, const RunContext& run, Embossed& embossed) {
    // Relief is small: a thousandth of it cannot be seen.
    constexpr double kTolerance = 1e-3;
    const DigitalSurface& surface = embossed.refined.surface;
    auto weights = weightsByRegion(surface, grid.labels, options.energy, run);
    if (!weights) return fail(weights.error());
    PointelVectors targets = displaced(embossed.refined, relief, normals.rest, run);
    const Energy energy(surface, std::move(normals.wanted), *std::move(weights), options.energy,
                        run, {embossed.refined.rest, std::move(normals.rest), std::move(targets)});
    const SolveOptions solve{.displacementLimit = std::nullopt,
                             .tolerance = std::max(options.solve.tolerance, kTolerance),
                             .maxIterations = options.solve.maxIterations};
    auto solution = minimize(energy, solve, run, {.rooms = &relief.rooms});
    if (!solution) return fail(solution.error());
    embossed.report.iterations = solution->iterations;
    embossed.report.residual = solution->residual;
    embossed.positions = std::move(solution->positions);
    return {};
}

void describe(const EmbossOptions& options, const Relief& relief, Embossed& embossed) {
    EmbossReport& report = embossed.report;
    report.detail = embossed.refined.detail;
    report.method = options.method == EmbossMethod::normals ? "normals" : "displace";
    report.surfels = embossed.refined.surface.surfelCount();
    report.pointels = embossed.refined.surface.pointelCount();
    for (std::size_t r = 0; r < options.rules.size(); ++r)
        report.tiles.push_back({options.rules[r].material, tileName(options.rules[r].tile.kind),
                                relief.surfelsOfRule[r]});
}

}  // namespace

Result<Embossed> emboss(const EmbossInput& input, const ConversionOptions& options,
                        const RunContext& run) {
    const EmbossOptions& wanted = options.emboss;
    const auto choice = TileChoice::make(input.grid, wanted, 1.0 / wanted.detail);
    if (!choice) return fail(choice.error());
    const auto tiles = placeTiles(
        {input.surface, input.links, input.normals, input.positions, sceneOrigin(input.grid)},
        *choice, run);
    auto refined = refineSurface(input.surface, input.links, input.positions, wanted.detail, run);
    if (!refined) return fail(refined.error());
    Embossed embossed{.refined = *std::move(refined)};
    const Relief relief = makeRelief(input, embossed.refined, tiles, wanted.rules.size(),
                                     options.method.solve.displacementLimit, run);
    if (run.stopped()) return fail(run.stopError());
    describe(wanted, relief, embossed);
    PieceNormals normals = pieceNormals(embossed.refined, relief, run);
    if (wanted.method == EmbossMethod::displace) {
        embossed.positions = displaced(embossed.refined, relief, normals.rest, run);
    } else {
        RunContext solving = run;
        solving.progress = [&run](Stage, double fraction) { run.report(Stage::emboss, fraction); };
        if (auto solved = alignToTiles(input.grid, relief, std::move(normals), options.method,
                                       solving, embossed);
            !solved)
            return fail(solved.error());
    }
    if (run.stopped()) return fail(run.stopError());
    return embossed;
}

}  // namespace rivage::core
