#include "proto/option_table.h"

#include <utility>

#include "proto/option_builders.h"

namespace rivage::proto {
namespace {

using core::ConversionOptions;

bool isRaw(const ConversionOptions& options) {
    return options.input.format == core::GridFormat::raw;
}

Option dimsOption() {
    return {{"dims",
             "input",
             OptionType::dims,
             {},
             1,
             65536,
             "Voxels along x, y and z of a raw grid, x fastest in memory."},
            [](JobOptions& options, const OptionValue& value) {
                options.conversion.input.dims = std::get<core::Vec3i>(value);
            },
            [](const JobOptions& options) -> Json {
                const auto& dims = options.conversion.input.dims;
                return dims ? Json::array({dims->x(), dims->y(), dims->z()}) : Json();
            }};
}

Json labelMapJson(const std::vector<core::LabelRule>& rules) {
    Json map = Json::object();
    for (const core::LabelRule& rule : rules)
        map[rule.name] = rule.rest ? Json("*") : Json(rule.values);
    return map;
}

Option labelsOption() {
    const std::vector<std::string> words{"auto", "solid", "material", "palette"};
    return {{"labels", "input", OptionType::labels, words, 0, 4294967295.0,
             "What makes a region of its own: auto takes the material class of a .vox and the "
             "stored value of other grids; a map names lists of palette entries or values."},
            [](JobOptions& options, const OptionValue& value) {
                core::InputOptions& input = options.conversion.input;
                if (const auto* word = std::get_if<Word>(&value)) {
                    input.labels = static_cast<core::LabelMode>(word->index);
                    return;
                }
                input.labels = core::LabelMode::map;
                input.labelMap = std::get<std::vector<core::LabelRule>>(value);
            },
            [words](const JobOptions& options) -> Json {
                const core::InputOptions& input = options.conversion.input;
                if (input.labels == core::LabelMode::map) return labelMapJson(input.labelMap);
                return words[static_cast<std::size_t>(input.labels)];
            }};
}

Option spacingOption() {
    return {
        {"spacing",
         "input",
         OptionType::spacing,
         {"auto"},
         1e-6,
         1e6,
         "Sides of a voxel along x, y and z, relative to each other; the longest is at most "
         "100 times the shortest. auto takes them from the file, and where it has none, cubes."},
        [](JobOptions& options, const OptionValue& value) {
            const auto* sides = std::get_if<core::Vec3d>(&value);
            options.conversion.input.spacing = sides ? std::optional(*sides) : std::nullopt;
        },
        [](const JobOptions& options) -> Json {
            const auto& spacing = options.conversion.input.spacing;
            return spacing ? Json::array({spacing->x(), spacing->y(), spacing->z()}) : Json("auto");
        }};
}

Option weightsOption() {
    return {{"weights",
             "method",
             OptionType::weights,
             {},
             1e-3,
             1e3,
             "Factors of alpha, beta and gamma by region; \"*\" is every other region. Faces "
             "between two regions take the mean of both."},
            [](JobOptions& options, const OptionValue& value) {
                options.conversion.method.energy.regions =
                    std::get<std::vector<core::RegionWeights>>(value);
            },
            [](const JobOptions& options) -> Json {
                Json map;  // null without regions
                for (const auto& region : options.conversion.method.energy.regions)
                    map[region.region] = {
                        {"alpha", region.alpha}, {"beta", region.beta}, {"gamma", region.gamma}};
                return map;
            }};
}

/// Setting the preset sets every method option, so it has to come first.
Option presetOption() {
    const std::vector<std::string> words{"studio", "paper", "organic", "architectural", "noisy"};
    return {{"preset", "method", OptionType::choice, words, 0, 0,
             "Sets every method option; those given beside it win."},
            [](JobOptions& options, const OptionValue& value) {
                options.conversion.preset = static_cast<core::Preset>(std::get<Word>(value).index);
                options.conversion.method = core::presetOptions(options.conversion.preset);
            },
            [words](const JobOptions& options) -> Json {
                return words[static_cast<std::size_t>(options.conversion.preset)];
            }};
}

Option progressiveOption() {
    return {
        {"progressive",
         "run",
         OptionType::flag,
         {},
         0,
         0,
         "Makes previews of the surface while the solver runs, for output=glb; the result stays "
         "the same."},
        [](JobOptions& options, const OptionValue& value) {
            options.run.progressive = std::get<bool>(value);
        },
        [](const JobOptions& options) -> Json { return options.run.progressive; }};
}

Option deadlineOption() {
    return {{"deadline_ms",
             "run",
             OptionType::integer,
             {},
             1,
             86400000,
             "Milliseconds from acceptance to the end, at most the server's deadline, which is the "
             "default; waiting in the queue counts."},
            [](JobOptions& options, const OptionValue& value) {
                options.run.deadlineMs = static_cast<std::uint64_t>(std::get<double>(value));
            },
            [](const JobOptions& options) -> Json {
                return options.run.deadlineMs ? Json(*options.run.deadlineMs) : Json();
            }};
}

void addInput(std::vector<Option>& table) {
    const auto input = [](auto member) {
        return [member](ConversionOptions & o) -> auto& { return o.input.*member; };
    };
    table.push_back(choice("format", "input", {"auto", "vox", "npy", "nrrd", "nifti", "vol", "raw"},
                           "Format of the grid; auto looks at the bytes. All but raw may be packed "
                           "by gzip.",
                           input(&core::InputOptions::format)));
    table.push_back(onlyWith("format=raw", dimsOption(), isRaw));
    table.push_back(onlyWith(
        "format=raw",
        choice("type", "input", {"u8", "u16"}, "Type of the values of a raw grid, little-endian.",
               input(&core::InputOptions::rawType)),
        isRaw));
    table.push_back(labelsOption());

    Option hidden = choice("hidden", "input", {"skip", "keep"},
                           "Whether hidden layers, groups and shapes are converted too.",
                           [](ConversionOptions& o) -> bool& { return o.input.keepHidden; });
    table.push_back(std::move(hidden));
    table.push_back(number("frame", "input", {0, 65535},
                           "Which model of a shape with several frames.",
                           input(&core::InputOptions::frame)));
    table.push_back(choice("border", "input", {"closed", "open"},
                           "Whether regions end at the border of the grid, or go on behind it: "
                           "then no face lies there.",
                           input(&core::InputOptions::border)));
    table.push_back(spacingOption());
}

void addEnergy(std::vector<Option>& table) {
    const auto energy = [](auto member) {
        return [member](ConversionOptions & o) -> auto& { return o.method.energy.*member; };
    };
    table.push_back(presetOption());
    table.push_back(number("alpha", "method", {1e-9, 1e6},
                           "Weight of the data term: stay near the voxels.",
                           energy(&core::EnergyOptions::alpha)));
    table.push_back(number("beta", "method", {0, 1e6},
                           "Weight of the alignment term: faces follow their normals.",
                           energy(&core::EnergyOptions::beta)));
    table.push_back(number("gamma", "method", {0, 1e6},
                           "Weight of the fairness term: vertices are evenly spaced.",
                           energy(&core::EnergyOptions::gamma)));
    table.push_back(choice("fairness", "method", {"umbrella", "tangential"},
                           "How vertices are spaced: the paper's umbrella, or within the surface.",
                           energy(&core::EnergyOptions::fairness)));
    table.push_back(choice("junction_fairness", "method", {"umbrella", "curve"},
                           "How vertices where three or more regions meet are spaced: as all "
                           "others, or along the curve.",
                           energy(&core::EnergyOptions::junctionFairness)));
    table.push_back(flag("split", "method",
                         "Whether sheets that only touch, as walls one voxel thick in diagonal "
                         "directions do, get vertices of their own there.",
                         energy(&core::EnergyOptions::split)));
    table.push_back(weightsOption());
}

bool isPiecewiseSmooth(const ConversionOptions& options) {
    return options.method.normals.method == core::NormalMethod::piecewiseSmooth;
}

void addNormals(std::vector<Option>& table) {
    using core::PiecewiseSmoothOptions;
    table.push_back(choice(
        "normals", "method",
        {"auto", "guided", "disc-vote", "convolved", "integral-invariant", "piecewise-smooth",
         "robust", "trivial"},
        "How the normal of each voxel face is estimated; auto looks at each place whether it is "
        "smooth, a crease or noisy.",
        [](ConversionOptions& o) -> core::NormalMethod& { return o.method.normals.method; }));
    table.push_back(onlyWith(
        "normals other than robust and trivial",
        numberOr(
            "auto", "radius", "method", {0.5, 32},
            "Radius of the normal estimation, in voxels; auto is what suits the method.",
            [](ConversionOptions & o) -> auto& { return o.method.normals.radius; }),
        [](const ConversionOptions& options) {
            const core::NormalMethod method = options.method.normals.method;
            return method != core::NormalMethod::robust && method != core::NormalMethod::trivial;
        }));
    const auto weight = [](auto member) {
        return [member](ConversionOptions & o) -> auto& {
            return o.method.normals.piecewiseSmooth.*member;
        };
    };
    table.push_back(onlyWith("normals=piecewise-smooth",
                             number("smoothing_alpha", "method", {1e-4, 100},
                                    "Piecewise smooth normals: the smaller, the larger the area "
                                    "that is smoothed over.",
                                    weight(&PiecewiseSmoothOptions::alpha)),
                             isPiecewiseSmooth));
    table.push_back(onlyWith("normals=piecewise-smooth",
                             number("smoothing_lambda", "method", {1e-4, 100},
                                    "Piecewise smooth normals: the smaller, the longer the sharp "
                                    "features may be.",
                                    weight(&PiecewiseSmoothOptions::lambda)),
                             isPiecewiseSmooth));
}

void addSolve(std::vector<Option>& table) {
    const auto solve = [](auto member) {
        return [member](ConversionOptions & o) -> auto& { return o.method.solve.*member; };
    };
    table.push_back(numberOr("none", "displacement_limit", "method", {0.001, 16},
                             "How far a vertex may move along each axis, in voxels; below 0.5 "
                             "every voxel centre keeps its side.",
                             solve(&core::SolveOptions::displacementLimit)));
    table.push_back(choice(
        "solver", "method",
        {"auto", "pcg", "multigrid", "projected", "accelerated", "gradient-descent", "cholesky"},
        "The minimizer; auto takes projected with a displacement limit, else multigrid.",
        solve(&core::SolveOptions::solver)));
    table.push_back(number("tolerance", "method", {1e-14, 0.1},
                           "Relative residual at which the solver stops.",
                           solve(&core::SolveOptions::tolerance)));
    table.push_back(number("max_iterations", "method", {1, 1000000},
                           "Iterations after which the solver gives up.",
                           solve(&core::SolveOptions::maxIterations)));
    table.push_back(flag("untangle", "method", "Whether inverted and crossing faces are repaired.",
                         solve(&core::SolveOptions::untangle)));
}

std::vector<Option> makeTable() {
    std::vector<Option> table;
    addInput(table);
    addEnergy(table);
    addNormals(table);
    addSolve(table);
    addResultOptions(table);
    table.push_back(deadlineOption());
    table.push_back(progressiveOption());
    return table;
}

}  // namespace

const std::vector<Option>& optionTable() {
    static const std::vector<Option> kTable = makeTable();
    return kTable;
}

}  // namespace rivage::proto
