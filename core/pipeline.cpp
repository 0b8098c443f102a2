#include "core/pipeline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/base/parallel.h"
#include "core/emboss/emboss.h"
#include "core/energy/energy.h"
#include "core/energy/weights.h"
#include "core/formats/read_scene.h"
#include "core/gltf/write_glb.h"
#include "core/gltf/write_obj.h"
#include "core/grid/scene.h"
#include "core/mesh/build_mesh.h"
#include "core/mesh/closed.h"
#include "core/mesh/crossing.h"
#include "core/mesh/inverted.h"
#include "core/normals/normal_field.h"
#include "core/size_check.h"
#include "core/solve/minimize.h"
#include "core/surface/digital_surface.h"
#include "core/surface/split_umbrellas.h"
#include "core/voxel_output.h"

namespace rivage::core {
namespace {

constexpr const char* kGlb = "model/gltf-binary";
// Neither format has a registered type; the names say more than application/octet-stream would.
constexpr const char* kVox = "application/x-magicavoxel";
constexpr const char* kNrrd = "application/x-nrrd";

/// A merged grid with what the report says about where it came from.
struct Input {
    VoxelGrid grid;
    InputReport report;
    std::vector<std::string> warnings;
};

/// Means nothing once `run` asked to stop.
InputReport describe(const Scene& scene, const VoxelGrid& grid, const InputOptions& options,
                     const RunContext& run) {
    InputReport report;
    report.format = scene.formatDetail;
    const Vec3i& size = grid.voxels.size();
    report.dims = {size.x(), size.y(), size.z()};
    report.spacing = {grid.spacing.x(), grid.spacing.y(), grid.spacing.z()};
    report.models = scene.models.size();
    report.instances = static_cast<std::uint64_t>(
        std::count_if(scene.instances.begin(), scene.instances.end(),
                      [&](const Instance& i) { return options.keepHidden || !i.hidden; }));
    report.materials = grid.materials.size() - 1;
    for (std::size_t l = 1; l < grid.labels.size(); ++l)
        report.labels.push_back({grid.labels.raw()[l], 0});
    const auto count = [&](const Vec3i&, MaterialId m) {
        ++report.voxels;
        ++report.labels[index(grid.materials[m].label) - 1U].voxels;
    };
    grid.voxels.forEachUntil([&] { return run.stopped(); }, count);
    return report;
}

Result<Input> readGrid(std::span<const std::byte> bytes, const InputOptions& options,
                       const RunContext& run) {
    run.report(Stage::parse, 0);
    auto scene = readScene(bytes, options, run);
    if (!scene) return fail(scene.error());
    auto grid = mergeScene(*scene, options, run);
    if (!grid) return fail(grid.error());
    InputReport report = describe(*scene, *grid, options, run);
    if (run.stopped()) return fail(run.stopError());
    return Input{*std::move(grid), std::move(report), std::move(scene->warnings)};
}

/// Means nothing once `run` asked to stop.
SurfaceReport describe(const DigitalSurface& surface, const VoxelGrid& grid,
                       const RunContext& run) {
    SurfaceReport report;
    report.pointels = surface.pointelCount();
    report.surfels = surface.surfelCount();
    serialFor(surface.pointelCount(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        // Each linel once, at its low end.
        for (int slot = 1; slot < kSlots; slot += 2) {
            report.linels += surface.neighbours[p][slot] != kNone<PointelId>;
            report.junctionLinels += surface.junctionSlots[p] >> slot & 1;
        }
        report.junctionPointels += surface.isJunctionPointel(p);
    });
    const auto name = [&](Label label) {
        return label == Label{0} ? std::string("background") : grid.labels[label];
    };
    for (const Interface& patch : surface.interfaces)
        report.interfaces.push_back({name(patch.labels.inner), name(patch.labels.outer),
                                     patch.end - patch.begin, std::nullopt});
    return report;
}

/// The digital surface as the later stages want it, with its links.
struct LinkedSurface {
    DigitalSurface surface;
    SurfelLinks links;
};

Result<LinkedSurface> makeSurface(const VoxelGrid& grid, const ConversionOptions& options,
                                  const RunContext& run, ConversionReport& report) {
    run.report(Stage::surface, 0);
    if (const auto size = checkSize(grid, &options, run); !size) return fail(size.error());
    auto surface = extractSurface(grid, run);
    if (!surface) return fail(surface.error());
    if (surface->surfelCount() == 0)
        return fail(ErrorCode::emptyGrid,
                    "no region ends inside the grid, so with an open border there is no surface",
                    "/options/border");
    auto links = linkSurfels(*surface, run);
    if (!links) return fail(links.error());
    report.surface = describe(*surface, grid, run);
    if (options.method.energy.split) {
        const auto split = splitUmbrellas(*surface, *links, run);
        if (!split) return fail(split.error());
        report.surface.splitPointels = *split;
    }
    if (run.stopped()) return fail(run.stopError());
    return LinkedSurface{*std::move(surface), *std::move(links)};
}

void describe(const std::vector<Closure>& closures, OutputReport& report) {
    for (const Closure closure : closures) {
        report.closed.push_back(closure == Closure::closed);
        report.openAtBorder.push_back(closure == Closure::openAtBorder);
    }
}

void measureDisplacement(const DigitalSurface& surface, const PointelVectors& positions,
                         const RunContext& run, SolveReport& report) {
    double squares = 0;
    serialFor(positions.size(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        const Vec3d d = positions[p] - surface.position(p);
        squares += d.squaredNorm();
        const double along = d.cwiseQuotient(surface.spacing).cwiseAbs().maxCoeff();
        report.displacementMax = std::max(report.displacementMax, along);
    });
    report.displacementRms = std::sqrt(squares / static_cast<double>(positions.size()));
}

/// What the estimators found, into the report.
void reportChoices(const NormalEstimate& estimate, SurfaceReport& report) {
    for (std::size_t i = 0; i < estimate.interfaces.size(); ++i) {
        const InterfaceNormals& choice = estimate.interfaces[i];
        report.interfaces[i].normals = {choice.noise, choice.sharp, choice.radius};
    }
    report.featureLinels = estimate.featureLinels;
}

/// Tells the energy of what the solver has so far, and makes artifacts of it. One that cannot be
/// made is left out: the conversion itself will say why.
Observer watcher(const VoxelGrid& grid, const LinkedSurface& made, const Energy& energy,
                 const OutputOptions& output, const RunContext& run) {
    const bool previews = run.preview && output.format == OutputFormat::glb;
    if (!run.energy && !previews) return {};
    return [&, previews](int step, const PointelVectors& positions) {
        const double value = energy.value(positions).total();
        if (run.energy) run.energy(step, value);
        if (!previews) return;
        const auto mesh = buildMesh(grid, made.surface, made.links, positions, output, run);
        if (!mesh) return;
        auto bytes = writeGlb(*mesh, output, {{"step", step}, {"energy", value}}, run);
        if (bytes) run.preview({step, value, *std::move(bytes), kGlb});
    };
}

/// Where the pointels have moved to, and the normals of the surfels that led them there.
struct Regularized {
    PointelVectors positions;
    NormalField normals;  ///< only if there is relief to be made
};

/// Normals, energy, minimizer and untangling.
Result<Regularized> regularize(const VoxelGrid& grid, const LinkedSurface& made,
                               const ConversionOptions& conversion, const RunContext& run,
                               ConversionReport& report) {
    const DigitalSurface& surface = made.surface;
    const SurfelLinks& links = made.links;
    const MethodOptions& options = conversion.method;
    auto weights = weightsByRegion(surface, grid.labels, options.energy, run);
    if (!weights) return fail(weights.error());
    run.report(Stage::normals, 0);
    auto estimate = estimateNormalsAndChoices(grid, surface, links, options.normals, run);
    if (!estimate) return fail(estimate.error());
    reportChoices(*estimate, report.surface);

    run.report(Stage::solve, 0);
    const Energy energy(surface, std::move(estimate->normals), *std::move(weights), options.energy,
                        run);
    auto solution = minimize(energy, options.solve, run, {},
                             watcher(grid, made, energy, conversion.output, run));
    if (!solution) return fail(solution.error());
    SolveReport& solve = report.solve;
    solve.solver = solution->solver;
    solve.iterations = solution->iterations;
    solve.residual = solution->residual;
    solve.before = energy.value(energy.restPositions());
    if (!solution->converged)
        report.warnings.push_back("the solver stopped at max_iterations, above its tolerance");

    PointelVectors& positions = solution->positions;
    const auto found = [&]() -> Tangles {
        return {invertedFaces(surface, positions, run).size(),
                crossingFaces(surface, positions, run).size()};
    };
    const Tangles before = options.solve.untangle ? untangle(surface, positions, run) : found();
    if (run.stopped()) return fail(run.stopError());
    const Tangles after = found();
    solve.invertedBefore = before.inverted;
    solve.invertedAfter = after.inverted;
    solve.crossingBefore = before.crossing;
    solve.crossingAfter = after.crossing;
    solve.after = energy.value(positions);
    measureDisplacement(surface, positions, run, solve);
    if (run.stopped()) return fail(run.stopError());
    return Regularized{std::move(positions),
                       conversion.emboss.rules.empty() ? NormalField() : energy.normals()};
}

void measureRelief(const RefinedSurface& refined, const PointelVectors& positions,
                   const RunContext& run, EmbossReport& report) {
    const Vec3d sides = refined.surface.spacing * refined.detail;
    double squares = 0;
    std::size_t moved = 0;
    serialFor(positions.size(), run, [&](std::size_t i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        const Vec3d relief = positions[p] - refined.rest[p];
        const Vec3d whole = (positions[p] - refined.surface.position(p)).cwiseQuotient(sides);
        moved += relief.isZero(0) ? 0 : 1;
        squares += relief.squaredNorm();
        report.reliefMax = std::max(report.reliefMax, relief.cwiseAbs().maxCoeff());
        report.displacementMax = std::max(report.displacementMax, whole.cwiseAbs().maxCoeff());
    });
    if (moved > 0) report.reliefRms = std::sqrt(squares / static_cast<double>(moved));
}

/// The surface with relief in place of the one without.
Result<LinkedSurface> addRelief(const VoxelGrid& grid, LinkedSurface made, Regularized& moved,
                                const ConversionOptions& options, const RunContext& run,
                                ConversionReport& report) {
    run.report(Stage::emboss, 0);
    auto embossed =
        emboss({grid, made.surface, made.links, moved.normals, moved.positions}, options, run);
    if (!embossed) return fail(embossed.error());
    made = {};
    RefinedSurface& refined = embossed->refined;
    PointelVectors& positions = embossed->positions;
    if (options.method.solve.untangle) untangle(refined.surface, positions, run, &refined.rest);
    EmbossReport& relief = report.emboss.emplace(std::move(embossed->report));
    relief.invertedAfter = invertedFaces(refined.surface, positions, run).size();
    relief.crossingAfter = crossingFaces(refined.surface, positions, run).size();
    measureRelief(refined, positions, run, relief);
    if (run.stopped()) return fail(run.stopError());
    moved = {std::move(positions), {}};
    return LinkedSurface{std::move(refined.surface), std::move(refined.links)};
}

Result<std::vector<std::byte>> writeMesh(const Mesh& mesh, const OutputOptions& options,
                                         const ConversionReport& report, const RunContext& run) {
    run.report(Stage::write, 0);
    switch (options.format) {
        case OutputFormat::glb: return writeGlb(mesh, options, toJson(report), run);
        case OutputFormat::obj: return writeObj(mesh, options, run);
        case OutputFormat::vox:
        case OutputFormat::nrrd: break;
    }
    return fail(ErrorCode::internal, "unknown output format");
}

/// Fills in what the artifact is, but for its bytes, which it returns.
Result<std::vector<std::byte>> makeMesh(const VoxelGrid& grid, const LinkedSurface& made,
                                        const PointelVectors& positions,
                                        const OutputOptions& options, const RunContext& run,
                                        Artifact& artifact) {
    run.report(Stage::mesh, 0);
    const auto mesh = buildMesh(grid, made.surface, made.links, positions, options, run);
    if (!mesh) return fail(mesh.error());
    const bool glb = options.format == OutputFormat::glb;
    artifact.mediaType = glb ? kGlb : "model/obj";
    artifact.extension = glb ? "glb" : "obj";
    artifact.report.output = {.mediaType = artifact.mediaType,
                              .vertices = vertexCount(*mesh),
                              .triangles = triangleCount(*mesh),
                              .parts = mesh->parts.size()};
    describe(labelClosures(grid, made.surface, run), artifact.report.output);
    if (run.stopped()) return fail(run.stopError());
    return writeMesh(*mesh, options, artifact.report, run);
}

/// As `makeMesh`, for the voxel outputs.
Result<std::vector<std::byte>> makeVoxels(const VoxelGrid& grid, const DigitalSurface& surface,
                                          const PointelVectors& positions,
                                          const OutputOptions& options, const RunContext& run,
                                          Artifact& artifact) {
    const bool vox = options.format == OutputFormat::vox;
    artifact.mediaType = vox ? kVox : kNrrd;
    artifact.extension = vox ? "vox" : "nrrd";
    artifact.report.output = {.mediaType = artifact.mediaType};
    describe(labelClosures(grid, surface, run), artifact.report.output);
    if (run.stopped()) return fail(run.stopError());
    return writeVoxels(grid, surface, positions, options, run, artifact.report);
}

std::string colorText(const Rgba8& color) {
    std::array<char, 10> text{};
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x%02x", color[0], color[1], color[2],
                  color[3]);
    return text.data();
}

}  // namespace

Result<Artifact> convert(std::span<const std::byte> input, const ConversionOptions& options,
                         const nlohmann::ordered_json& optionsEcho, const RunContext& run) {
    auto read = readGrid(input, options.input, run);
    if (!read) return fail(read.error());
    const VoxelGrid& grid = read->grid;
    Artifact artifact;
    ConversionReport& report = artifact.report;
    report.input = read->report;
    report.options = optionsEcho;
    report.warnings = read->warnings;

    auto made = makeSurface(grid, options, run, report);
    if (!made) return fail(made.error());
    auto moved = regularize(grid, *made, options, run, report);
    if (!moved) return fail(moved.error());
    if (!options.emboss.rules.empty()) {
        made = addRelief(grid, *std::move(made), *moved, options, run, report);
        if (!made) return fail(made.error());
    }

    auto bytes =
        isVoxels(options.output.format)
            ? makeVoxels(grid, made->surface, moved->positions, options.output, run, artifact)
            : makeMesh(grid, *made, moved->positions, options.output, run, artifact);
    if (!bytes) return fail(bytes.error());
    artifact.bytes = *std::move(bytes);
    report.output.bytes = artifact.bytes.size();
    run.report(Stage::write, 1);
    return artifact;
}

Result<Inspection> inspect(std::span<const std::byte> input, const InputOptions& options,
                           const RunContext& run) {
    auto read = readGrid(input, options, run);
    if (!read) return fail(read.error());
    const VoxelGrid& grid = read->grid;
    run.report(Stage::surface, 0);
    const auto size = checkSize(grid, nullptr, run);
    if (!size) return fail(size.error());

    Inspection inspection;
    inspection.input = read->report;
    inspection.surfels = size->surfels;
    inspection.pointels = size->pointels;
    inspection.predictedMemory = predictMemory(grid, *size);
    inspection.warnings = read->warnings;
    for (std::size_t m = 1; m < grid.materials.size(); ++m) {
        const Material& material = grid.materials.raw()[m];
        inspection.palette.push_back({material.source, colorText(material.color),
                                      grid.labels[material.label], className(material.kind),
                                      material.name});
    }
    return inspection;
}

}  // namespace rivage::core
