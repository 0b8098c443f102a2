#include "tests/study/report.h"

#include "tests/study/view.h"
#include "tests/study/words.h"

namespace rivage::study {
namespace {

using Names = std::vector<std::string>;

const char* const kSettings = R"TEXT(
Methods. `raw`: the voxel surface. `MC`: marching cubes with mid-point vertices, once for each
label. `DC`: dual contouring, a quadric of the planes through the crossing points, singular values
below 0.1 of the largest cut off; `DC in cell` puts vertices back into their cell. `SN`, `SN 16`:
surface nets without and with 16 half-way steps, kept in their cells. `paper`: the exact minimum of
the energy of the paper (weights 0.001, 1, 0.05, no limit) with integral invariants of radius 3;
`paper, auto normals`: the same with the normals that `studio` has. `studio`, `architectural`,
`organic`, `noisy`: the presets. `studio, no limit`, `guided`, `AT` (piecewise smooth), `II`:
`studio` with one thing changed. `growing II`: integral invariants whose radius grows with the
resolution as N^(2/3).

Fairness. DC has the same normals as `studio` and `paper, auto normals`, and under noise the same
noisy ones, surfel by surfel. MC, SN and DC find crossing points half-way between voxel centres, as
labels know no better; position noise moves these along their edges, and our vertices' rest
positions along all three axes. MC, SN and SN 16 use no normals, so noise of the normals leaves them
as they are.

Figures. Distances in voxels from the vertices to the true interface (of several, the farthest);
normals of faces against the true ones, in degrees, weighted by area. "a +- b" and "q (a to b)" are
means with 95 % intervals of Student's t over the poses: random rotations with random shifts of up
to half a voxel, the same for all methods. A mean over shapes is taken pose by pose first.
)TEXT";

const View::Query& at(View::Query& query, const std::string& shape, const std::string& method) {
    query.shape = shape;
    query.method = method;
    return query;
}

/// Shapes down, methods across.
std::string byShape(const View& view, const Names& methods, View::Query query, int digits) {
    Names cells = methods;
    cells.insert(cells.begin(), "shape");
    std::string text = head(cells);
    Names shapes = view.shapes();
    shapes.emplace_back();
    for (const std::string& shape : shapes) {
        cells = {shape.empty() ? "**all**" : shape};
        for (const std::string& method : methods)
            cells.push_back(words(view.mean(at(query, shape, method)), digits));
        text += row(cells);
    }
    return text;
}

/// Levels down, methods across, the mean over all shapes.
std::string byLevel(const View& view, const Names& methods, View::Query query, int digits) {
    Names cells = methods;
    cells.insert(cells.begin(), "level");
    std::string text = head(cells);
    for (const double level : view.levels()) {
        query.level = level;
        cells = {decimals(level, 2)};
        for (const std::string& method : methods)
            cells.push_back(words(view.mean(at(query, {}, method)), digits));
        text += row(cells);
    }
    return text;
}

/// Quotients of a method to others, levels down.
std::string quotients(const View& view, const std::string& method, const Names& peers,
                      Measure measure) {
    Names cells = peers;
    cells.insert(cells.begin(), "level");
    std::string text = head(cells);
    for (const double level : view.levels()) {
        cells = {decimals(level, 2)};
        for (const std::string& peer : peers)
            cells.push_back(
                words(view.ratio({.method = method, .level = level, .measure = measure}, peer)));
        text += row(cells);
    }
    return text;
}

/// rms / max / normal error for every shape and level.
std::string everyCase(const View& view, const Names& methods) {
    Names cells = methods;
    cells.insert(cells.begin(), "shape, level");
    std::string text = head(cells);
    for (const std::string& shape : view.shapes())
        for (const double level : view.levels()) {
            cells = {shape + ", " + decimals(level, 2)};
            for (const std::string& method : methods) {
                View::Query query{.shape = shape, .method = method, .level = level};
                std::string cell = words(view.mean(query), 3);
                query.measure = Measure::max;
                cell += " / " + words(view.mean(query), 2);
                query.measure = Measure::normalMean;
                cells.push_back(cell + " / " + words(view.mean(query), 1));
            }
            text += row(cells);
        }
    return text;
}

std::string figure(const std::string& name, const std::string& words) {
    return "\n![" + words + "](plots/" + name + ".svg)\n\n";
}

std::string shapesText(const View& view) {
    const Names methods = view.methods();
    std::string text = figure("shapes", "rms distance and normal error by method") +
                       "rms distance:\n\n" + byShape(view, methods, {.measure = Measure::rms}, 3) +
                       "\nLargest distance, both ways (of "
                       "the vertices, and of samples of the true surface):\n\n" +
                       byShape(view, methods, {.measure = Measure::hausdorff}, 2) +
                       "\nNormal error:\n\n" +
                       byShape(view, methods, {.measure = Measure::normalMean}, 1);
    text +=
        "\nWhat is wrong, the mean over all shapes: signed distance (negative: shrunk), volume "
        "in percent, corners more than a right angle off and faces below 2 % of their area, in "
        "percent, pairs of faces that intersect without a common vertex, voxel centres on the "
        "wrong side. `-`: does not apply.\n\n" +
        head({"method", "signed", "volume", "inverted", "degenerate", "crossing", "wrong"});
    for (const std::string& method : methods) {
        Names cells = {method};
        for (const Measure measure : {Measure::bias, Measure::volume, Measure::inverted,
                                      Measure::degenerate, Measure::crossing, Measure::wrong})
            cells.push_back(words(view.mean({.method = method, .measure = measure}),
                                  measure == Measure::bias ? 3 : 2));
        text += row(cells);
    }
    return text;
}

std::string normalNoiseText(const View& view) {
    const Names peers = {"MC", "DC", "DC in cell", "SN", "SN 16"};
    return figure("normal-noise", "errors under noise of the normals") +
           "rms distance of `studio` over that of the others:\n\n" +
           quotients(view, "studio", peers, Measure::rms) + "\nNormal error of `studio`:\n\n" +
           quotients(view, "studio", peers, Measure::normalMean) +
           "\nrms distance of `paper, auto normals`:\n\n" +
           quotients(view, "paper, auto normals", peers, Measure::rms) +
           "\nNormal error of `paper, auto normals`:\n\n" +
           quotients(view, "paper, auto normals", peers, Measure::normalMean) +
           "\nCrossing faces, the mean over all shapes:\n\n" +
           byLevel(view, {"DC", "DC in cell", "paper, auto normals", "studio, no limit", "studio"},
                   {.measure = Measure::crossing}, 1) +
           "\nEvery shape and level: rms / largest distance / normal error.\n\n" +
           everyCase(view, {"studio", "paper, auto normals", "DC", "SN", "SN 16", "MC"});
}

std::string positionNoiseText(const View& view) {
    const Names methods = {"raw",   "MC", "DC", "DC in cell", "SN", "SN 16", "paper, auto normals",
                           "studio"};
    return figure("position-noise", "errors under noise of the positions") +
           "rms distance, the mean over all shapes:\n\n" +
           byLevel(view, methods, {.measure = Measure::rms}, 3) + "\nNormal error:\n\n" +
           byLevel(view, methods, {.measure = Measure::normalMean}, 1) +
           "\nEvery shape and level: rms / largest distance / normal error.\n\n" +
           everyCase(view, {"studio", "paper, auto normals", "DC", "SN", "SN 16", "MC"});
}

std::string labelNoiseText(const View& view) {
    const Names methods = view.methods();
    return "Voxels at distance d from another label flip to it with probability k^d. Parts of "
           "fewer than 40 faces are left out, for all methods.\n" +
           figure("label-noise", "errors under noise of the labels") + "rms distance:\n\n" +
           byLevel(view, methods, {.measure = Measure::rms}, 3) + "\nNormal error:\n\n" +
           byLevel(view, methods, {.measure = Measure::normalMean}, 1) +
           "\nVoxel centres that get another label than they had without noise:\n\n" +
           byLevel(view, {"DC", "DC in cell", "SN 16", "paper", "studio", "noisy"},
                   {.measure = Measure::untrue}, 0);
}

std::string creasesText(const View& view) {
    const Names methods = view.methods();
    return figure("creases", "normal errors beside creases and away from them") +
           "Normal error of faces 1 to 3 voxels from a crease or junction:\n\n" +
           byShape(view, methods, {.measure = Measure::nearCrease}, 1) +
           "\nOf those farther away:\n\n" +
           byShape(view, methods, {.measure = Measure::farCrease}, 1) +
           "\nError of the estimated normals at least 1 voxel from a crease:\n\n" +
           byShape(view, {"studio", "architectural", "guided", "AT", "II", "organic"},
                   {.measure = Measure::estimate}, 1) +
           "\nrms distance:\n\n" + byShape(view, methods, {.measure = Measure::rms}, 3);
}

/// Orders of convergence by shape and method.
std::string orders(const View& view, Measure measure, double exponent) {
    Names cells = view.shapes();
    cells.insert(cells.begin(), "method");
    std::string text = head(cells);
    for (const std::string& method : view.methods()) {
        cells = {method};
        for (const std::string& shape : view.shapes()) {
            std::vector<std::pair<double, double>> points;
            for (const Sample& s : view.samples())
                if (s.shape == shape && s.method == method)
                    points.emplace_back(1.0 / s.resolution,
                                        std::pow(s.resolution, exponent) * s.measures[measure]);
            cells.push_back(words(orderOf(points), 2));
        }
        text += row(cells);
    }
    return text;
}

/// A row a method and a column a resolution, with what `cell(method, resolution)` says.
template <typename Cell>
std::string byResolution(const View& view, Cell&& cell) {
    Names cells = {"method"};
    for (const int n : view.resolutions()) cells.push_back(std::to_string(n));
    std::string text = head(cells);
    for (const std::string& method : view.methods()) {
        cells = {method};
        for (const int n : view.resolutions()) cells.push_back(cell(method, n));
        text += row(cells);
    }
    return text;
}

std::string byResolution(const View& view, Measure measure, int digits) {
    return byResolution(view, [&](const std::string& method, int n) {
        return words(view.mean({.method = method, .measure = measure, .resolution = n}), digits);
    });
}

std::string timesByResolution(const View& view) {
    return byResolution(view, [&](const std::string& method, int n) {
        return decimals(view.time(method, n).mean, 0);
    });
}

std::string convergenceText(const View& view) {
    return "h = 1/N; a shape has a diameter of about 0.85. Poses: 8 up to 64, 4 at 128, 2 at 256 "
           "unless fewer were asked for; the growing radius only up to 128.\n" +
           figure("convergence-distance", "rms distance in object units against N") +
           figure("convergence-normals", "normal error against N") +
           "Fitted order of the rms distance in object units, with the interval of the slope:\n\n" +
           orders(view, Measure::rms, -1) + "\nFitted order of the normal error of faces:\n\n" +
           orders(view, Measure::normalMean, 0) +
           "\nrms distance in voxels by N, the mean over the shapes:\n\n" +
           byResolution(view, Measure::rms, 3) + "\nNormal error by N:\n\n" +
           byResolution(view, Measure::normalMean, 2) +
           "\nMilliseconds of one thread by N, the mean over the shapes, normals included:\n\n" +
           timesByResolution(view);
}

std::string speedText(const View& view) {
    std::string text = figure("speed", "normals against those of the minimum by steps") +
                       head({"steps", "gradient descent: degrees", "voxels", "ms",
                             "accelerated: degrees", "voxels", "ms"});
    for (const double steps : view.levels()) {
        Names cells = {decimals(steps, 0)};
        for (const char* method : {"gradient descent", "accelerated"})
            for (const Sample& s : view.samples())
                if (s.method == method && s.level == steps) {
                    cells.push_back(decimals(s.measures[Measure::normalMean], 2));
                    cells.push_back(decimals(s.measures[Measure::rms], 3));
                    cells.push_back(decimals(s.milliseconds, 1));
                }
        text += row(cells);
    }
    const Sample& gradient = view.samples().front();
    return text + "\nOne gradient of the energy: " + decimals(gradient.milliseconds, 2) +
           " ms for " + decimals(gradient.measures[Measure::faces], 0) +
           " faces, on one thread. Degrees and voxels are rms differences to the minimum of "
           "`studio`.\n";
}

struct Section {
    const char* name;
    const char* title;
    std::string (*text)(const View&);
};
constexpr Section kSections[] = {
    {"shapes", "Clean shapes", shapesText},
    {"normal-noise", "Noise of the normals", normalNoiseText},
    {"position-noise", "Noise of the positions", positionNoiseText},
    {"label-noise", "Noise of the labels", labelNoiseText},
    {"creases", "Creases", creasesText},
    {"convergence", "Convergence", convergenceText},
    {"speed", "Speed", speedText},
};

std::string countText(const Samples& samples, double seconds) {
    const View view(samples);
    int poses = 0;
    for (const Sample& sample : samples) poses = std::max(poses, sample.pose + 1);
    std::string sizes;
    for (const int n : view.resolutions()) sizes += (sizes.empty() ? "" : ", ") + std::to_string(n);
    return std::to_string(view.shapes().size()) + " shapes, up to " + std::to_string(poses) +
           " poses, grids of " + sizes + " along an axis, " + std::to_string(samples.size()) +
           " runs in " + decimals(seconds, 0) + " s.\n";
}

}  // namespace

std::string writeReport(const Measured& measured, const RunFacts& facts) {
    double total = 0;
    for (const auto& [name, seconds] : facts.seconds) total += seconds;
    std::string text = "# Results of the study\n\nMade by `./dev study --save` from commit " +
                       facts.commit + ": " + decimals(total / 60, 1) + " minutes with " +
                       std::to_string(facts.threads) + " threads, at a load average of " +
                       decimals(facts.load, 1) + " on " + std::to_string(facts.cores) +
                       " cores. Everything but the times is the same in every run.\n" + kSettings +
                       writeVerdicts(measured);
    for (const Section& section : kSections) {
        text += std::string("\n## ") + section.title + "\n\n";
        const auto found = measured.find(section.name);
        if (found == measured.end()) {
            text += std::string("Not measured: `./dev study ") + section.name + "`.\n";
            continue;
        }
        const auto spent = facts.seconds.find(section.name);
        text += countText(found->second, spent == facts.seconds.end() ? 0 : spent->second);
        text += section.text(View(found->second));
    }
    return text;
}

}  // namespace rivage::study
