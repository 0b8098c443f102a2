#include "tests/study/methods.h"

#include <random>
#include <utility>

#include "tests/study/minimize_from.h"
#include "tests/study/peers.h"
#include "tests/study/thread_clock.h"
#include "tests/support/accuracy.h"
#include "tests/support/random.h"

namespace rivage::study {
namespace {

MethodOptions withNormals(Preset preset, NormalMethod normals) {
    MethodOptions options = presetOptions(preset);
    options.normals = {.method = normals};
    return options;
}

std::vector<Method> allMethods() {
    std::vector<Method> all = {
        {"raw", Kind::raw, {}},
        {"MC", Kind::marchingCubes, {}},
        {"DC", Kind::dualContouring, {}},
        {"DC in cell", Kind::dualContouringInCell, {}},
        {"SN", Kind::surfaceNets, {}},
        {"SN 16", Kind::surfaceNets16, {}},
        {"paper", Kind::energy, presetOptions(Preset::paper)},
        {"paper, auto normals", Kind::energy, withNormals(Preset::paper, NormalMethod::automatic)},
        {"studio", Kind::energy, presetOptions(Preset::studio)},
        {"architectural", Kind::energy, presetOptions(Preset::architectural)},
        {"organic", Kind::energy, presetOptions(Preset::organic)},
        {"noisy", Kind::energy, presetOptions(Preset::noisy)},
        {"guided", Kind::energy, withNormals(Preset::studio, NormalMethod::guided)},
        {"AT", Kind::energy, withNormals(Preset::studio, NormalMethod::piecewiseSmooth)},
        {"II", Kind::energy, withNormals(Preset::studio, NormalMethod::integralInvariant)}};
    MethodOptions noBox = presetOptions(Preset::studio);
    noBox.solve.displacementLimit = std::nullopt;
    all.push_back({"studio, no limit", Kind::energy, noBox});
    return all;
}

}  // namespace

const Method& method(const std::string& name) {
    static const std::vector<Method> all = allMethods();
    for (const Method& one : all)
        if (one.name == name) return one;
    std::abort();
}

const test::Regularized& Bench::linked(bool split) {
    auto& kept = linked_[split ? 1 : 0];
    if (!kept) {
        MethodOptions options;
        options.energy.split = split;
        kept = test::linkedSurface(grid_, options);
    }
    return *kept;
}

const DigitalSurface& Bench::whole() { return linked(false).surface; }

// Split or not, a surface has the same surfels and links, so normals are estimated once for both.
const Bench::Field& Bench::field(const NormalOptions& options) {
    for (const auto& one : fields_)
        if (one->options.method == options.method && one->options.radius == options.radius)
            return *one;
    const test::Regularized& base = linked(false);
    const ThreadClock clock;
    NormalField normals = *estimateNormals(grid_, base.surface, base.links, options, {});
    const double spent = clock.milliseconds();
    if (disturbance_.normalTilt > 0)
        normals = test::tilted(normals, disturbance_.normalTilt, disturbance_.seed);
    fields_.push_back(std::make_unique<Field>(Field{options, std::move(normals), spent}));
    return *fields_.back();
}

PointelVectors Bench::movedRest(const DigitalSurface& surface) const {
    std::mt19937 random(disturbance_.seed);
    PointelVectors rest(surface.pointelCount());
    for (std::uint32_t i = 0; i < rest.size(); ++i) {
        Vec3d& p = rest[PointelId{i}];
        p = surface.position(PointelId{i});
        for (double& x : p) x += disturbance_.positionNoise * (2 * test::unitDraw(random) - 1);
    }
    return rest;
}

void Bench::runEnergy(const MethodOptions& options, Outcome& outcome) {
    const Field& normals = field(options.normals);
    test::Regularized result = linked(options.energy.split);
    result.normals = normals.normals;
    const ThreadClock clock;
    if (disturbance_.positionNoise > 0) {
        const Energy energy(result.surface, result.normals,
                            EnergyWeights::uniform(result.surface, options.energy), options.energy,
                            1);
        result.positions =
            minimizeFrom(energy, movedRest(result.surface), options.solve.displacementLimit);
        if (options.solve.untangle) untangle(result.surface, result.positions, {});
    } else {
        test::alignToNormals(result, options);
    }
    outcome.milliseconds = normals.milliseconds + clock.milliseconds();
    outcome.surface = std::move(result.surface);
    outcome.positions = std::move(result.positions);
    outcome.normals = std::move(result.normals);
}

void Bench::runDual(Kind kind, Outcome& outcome) {
    outcome.surface = whole();
    const bool needsNormals = kind == Kind::dualContouring || kind == Kind::dualContouringInCell;
    if (needsNormals) {
        const Field& normals = field({});
        outcome.normals = normals.normals;
        outcome.milliseconds = normals.milliseconds;
    }
    const ThreadClock clock;
    const Crossings points = crossings(whole(), disturbance_.positionNoise, disturbance_.seed);
    if (needsNormals) {
        outcome.positions =
            dualContouring(whole(), points, outcome.normals, kind == Kind::dualContouringInCell);
    } else {
        outcome.positions = surfaceNets(whole(), points, kind == Kind::surfaceNets16 ? 16 : 0);
    }
    outcome.milliseconds += clock.milliseconds();
}

Outcome Bench::run(const Method& method) {
    Outcome outcome;
    if (method.kind == Kind::energy) {
        runEnergy(method.options, outcome);
    } else if (method.kind == Kind::marchingCubes) {
        const ThreadClock clock;
        const Crossings points = crossings(whole(), disturbance_.positionNoise, disturbance_.seed);
        outcome.mesh = marchingCubes(grid_, whole(), points);
        outcome.milliseconds = clock.milliseconds();
        return outcome;
    } else if (method.kind == Kind::raw) {
        outcome.surface = whole();
        outcome.positions = movedRest(outcome.surface);
    } else {
        runDual(method.kind, outcome);
    }
    outcome.mesh = meshOf(outcome.surface, outcome.positions);
    return outcome;
}

}  // namespace rivage::study
