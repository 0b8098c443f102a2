#include <algorithm>
#include <functional>
#include <numbers>

#include "tests/study/report.h"
#include "tests/study/view.h"
#include "tests/study/words.h"

namespace rivage::study {
namespace {

// What a claim must reach. Figures of the report are compared with these and nothing else.
constexpr double kOrderOfDistance = 0.9;  // in object units: 1 is O(h)
constexpr double kOrderOfNormals = 0.5;   // the theorem of integral invariants has 2/3
constexpr int kFine = 64;                 // coarser grids tell little about h going to 0
constexpr double kFarMoreStable = 0.25;   // of the error that position noise adds to the others
constexpr double kNearCrease = 5;         // degrees, 1 to 3 voxels from a crease
constexpr double kShrinks = 0.05;         // voxels of mean signed distance
constexpr double kGradientStep = 3;       // ms, the figure of [CGL18]
constexpr int kFewSteps = 10;             // of [CGL18]
constexpr double kAcceptable = 3;         // degrees from the normals of the minimum

enum class Outcome : std::uint8_t { holds, partly, fails, notMeasured };

struct Verdict {
    std::string claim;
    std::string figure;
    Outcome outcome = Outcome::notMeasured;
    std::string why = {};  ///< for a claim that does not hold everywhere
};

const char* nameOf(Outcome outcome) {
    switch (outcome) {
        case Outcome::holds: return "**holds**";
        case Outcome::partly: return "**partly**";
        case Outcome::fails: return "**fails**";
        case Outcome::notMeasured: return "not measured";
    }
    return "";
}

Outcome allOf(int held, int of) {
    return held == of ? Outcome::holds : held == 0 ? Outcome::fails : Outcome::partly;
}

Outcome require(bool held) { return held ? Outcome::holds : Outcome::fails; }

using Names = std::vector<std::string>;
const Names kOurs = {"paper, auto normals", "studio"};

/// Where a comparison is lost.
std::string onShapes(const Names& worse, std::size_t of) {
    if (worse.empty()) return {};
    return worse.size() == of ? ", worse on every shape" : ", worse on " + joined(worse);
}

/// A smaller measure than a peer's at every level of a disturbance.
Verdict smaller(const View& view, const std::string& method, const std::string& peer,
                Measure measure, const std::string& what) {
    Verdict verdict{"`" + method + "` has smaller " + what + " than " + peer + " at every level",
                    {},
                    Outcome::notMeasured};
    int held = 0;
    bool everywhere = true;
    const std::vector<double> levels = view.levels();
    for (const double level : levels) {
        const View::Query query{.method = method, .level = level, .measure = measure};
        const Ratio ratio = view.ratio(query, peer);
        const Names worse = view.worseShapes(query, peer);
        held += ratio.less();
        everywhere = everywhere && worse.empty();
        verdict.figure += (verdict.figure.empty() ? "" : "; ") + decimals(level, 1) + ": " +
                          words(ratio) + onShapes(worse, view.shapes().size());
    }
    verdict.outcome = allOf(held, static_cast<int>(levels.size()));
    if (verdict.outcome == Outcome::holds && !everywhere) verdict.outcome = Outcome::partly;
    return verdict;
}

/// What the largest position noise adds to the rms distance, against the least of the peers.
Verdict stable(const View& view, const std::string& method) {
    const double most = view.levels().back();
    const auto added = [&](const std::string& name) {
        return view.mean({.method = name, .level = most}).mean -
               view.mean({.method = name, .level = 0}).mean;
    };
    const double ours = added(method);
    const double mc = added("MC");
    const double dc = std::min(added("DC"), added("DC in cell"));
    return {"`" + method +
                "` is far more stable than MC and DC under position noise: it adds at "
                "most a quarter of what it adds to them",
            "rms distance added by +-" + decimals(most, 2) + ": " + decimals(ours, 4) + ", DC " +
                decimals(dc, 4) + ", MC " + decimals(mc, 4),
            require(ours <= kFarMoreStable * std::min(mc, dc))};
}

/// Over the resolutions from `least` on.
Interval orderFor(const View& view, const View::Query& query, double exponent, int least = 0) {
    std::vector<std::pair<double, double>> points;
    for (const Sample& sample : view.samples())
        if (sample.shape == query.shape && sample.method == query.method &&
            sample.resolution >= least)
            points.emplace_back(1.0 / sample.resolution, std::pow(sample.resolution, exponent) *
                                                             sample.measures[query.measure]);
    return orderOf(points);
}

/// The order of the distance in object units on every shape, over all grids and over fine ones.
Verdict converges(const View& view, const std::string& method) {
    int held = 0;
    std::string figure;
    const Names shapes = view.shapes();
    for (const std::string& shape : shapes) {
        const View::Query query{.shape = shape, .method = method};
        const Interval order = orderFor(view, query, -1);
        const Interval fine = orderFor(view, query, -1, kFine);
        held += order.mean >= kOrderOfDistance && !(fine.mean < kOrderOfDistance);
        figure += (figure.empty() ? "" : "; ") + shape + " " + words(order, 2) + ", from " +
                  std::to_string(kFine) + " on " + words(fine, 2);
    }
    return {"`" + method + "`: rms distance falls with h at order " +
                decimals(kOrderOfDistance, 1) + " or more, over all grids and over those of " +
                std::to_string(kFine) + " and more",
            figure, allOf(held, static_cast<int>(shapes.size()))};
}

/// At least one method whose face normals converge, on every shape.
Verdict normalsConverge(const View& view) {
    int held = 0;
    std::string figure;
    const Names shapes = view.shapes();
    for (const std::string& shape : shapes) {
        Interval best{-1e9, 0};
        std::string name;
        for (const std::string& method : view.methods()) {
            const Interval order = orderFor(
                view, {.shape = shape, .method = method, .measure = Measure::normalMean}, 0);
            if (order.mean > best.mean) {
                best = order;
                name = method;
            }
        }
        held += best.mean > kOrderOfNormals;
        figure += (figure.empty() ? "" : "; ") + shape + " " + words(best, 2) + " (" + name + ")";
    }
    return {"face normals converge at an order above " + decimals(kOrderOfNormals, 1) +
                " for at least one method",
            figure, allOf(held, static_cast<int>(shapes.size()))};
}

Verdict piecewiseSmooth(const View& view, const std::string& method) {
    const View::Query query{.method = method, .measure = Measure::nearCrease};
    const double error = view.mean(query).mean;
    std::string figure = decimals(error, 1) + " degrees at 1 to 3 voxels from a crease; to others:";
    int held = error <= kNearCrease;
    int of = 1;
    for (const char* peer : {"MC", "DC", "SN 16"}) {
        const Ratio ratio = view.ratio(query, peer);
        const Names worse = view.worseShapes(query, peer);
        figure += std::string(of == 1 ? " " : "; ") + peer + " " + words(ratio) +
                  onShapes(worse, view.shapes().size());
        held += ratio.less() && worse.empty();
        ++of;
    }
    return {"`" + method + "` is piecewise smooth: faces beside creases are off by at most " +
                decimals(kNearCrease, 0) + " degrees, and less than those of MC, DC and SN 16",
            figure, allOf(held, of)};
}

Verdict keepsSize(const View& view, const std::string& method) {
    int held = 0;
    double worst = 0;
    std::string where;
    const Names shapes = view.shapes();
    for (const std::string& shape : shapes) {
        const double bias =
            view.mean({.shape = shape, .method = method, .measure = Measure::bias}).mean;
        held += bias >= -kShrinks;
        if (bias >= worst) continue;
        worst = bias;
        where = shape;
    }
    return {"`" + method + "` does not shrink clean shapes: mean signed distance at least -" +
                decimals(kShrinks, 2),
            where.empty() ? "none below 0"
                          : "worst " + decimals(worst, 3) + " (" + where + "); kept by " +
                                std::to_string(held) + " of " + std::to_string(shapes.size()),
            allOf(held, static_cast<int>(shapes.size()))};
}

/// Voxel centres, crossings and distance of the presets with a limit of 0.49.
Verdict guarantees(const Measured& measured) {
    double wrong = 0;
    double crossing = 0;
    double farthest = 0;
    double runs = 0;
    double withoutCrossing = 0;
    for (const char* section : {"shapes", "normal-noise", "position-noise"}) {
        const auto found = measured.find(section);
        if (found == measured.end()) continue;
        for (const Sample& s : found->second) {
            if (s.method != "studio" && s.method != "organic" && s.method != "architectural")
                continue;
            ++runs;
            wrong += s.measures[Measure::wrong];
            crossing += s.measures[Measure::crossing];
            withoutCrossing += s.measures[Measure::crossing] == 0;
            farthest = std::max(farthest, s.measures[Measure::max]);
        }
    }
    return {
        "with a limit of 0.49 every voxel centre keeps its label, faces without a common "
        "vertex do not intersect, no vertex is farther than sqrt(3) voxels, in any noise",
        decimals(runs, 0) + " runs: " + decimals(wrong, 0) + " wrong centres, " +
            decimals(crossing, 0) + " crossings, farthest vertex " + decimals(farthest, 2),
        runs == 0 ? Outcome::notMeasured
                  : require(wrong == 0 && crossing == 0 && farthest <= std::numbers::sqrt3)};
}

Verdict gradientStep(const View& view) {
    const double ms = view.time("one gradient", 64).mean;
    return {"a gradient takes less than " + decimals(kGradientStep, 0) +
                " ms on a scene as large as the Lake",
            decimals(ms, 2) + " ms on one thread of this machine", require(ms < kGradientStep)};
}

Verdict fewSteps(const View& view, const std::string& method) {
    View::Query query{.method = method, .level = kFewSteps, .measure = Measure::normalMean};
    const double after = view.mean(query).mean;
    query.level = 0;
    return {
        "`" + method + "`: acceptable after " + std::to_string(kFewSteps) +
            " steps: face normals within " + decimals(kAcceptable, 0) + " degrees of the minimum's",
        decimals(after, 1) + " degrees (the voxels: " + decimals(view.mean(query).mean, 1) + ")",
        require(after <= kAcceptable)};
}

using Verdicts = std::vector<Verdict>;

/// With the reason, where a claim does not hold everywhere.
Verdict explained(Verdict verdict, const std::string& why) {
    if (verdict.outcome == Outcome::partly || verdict.outcome == Outcome::fails) verdict.why = why;
    return verdict;
}

std::string meanBias(const View& view, const std::string& method, double level) {
    return decimals(view.mean({.method = method, .level = level, .measure = Measure::bias}).mean,
                    2);
}

/// Why a method loses under noise of the normals, by how far its shapes shrank.
std::string whyNoise(const View& view, const std::string& method) {
    const double most = view.levels().back();
    const std::string sizes = "mean signed distance " + meanBias(view, method, 0) + " at 0, " +
                              meanBias(view, method, most) + " at " + decimals(most, 0) +
                              " degrees";
    if (view.mean({.method = method, .level = most, .measure = Measure::bias}).mean > -0.5)
        return "the errors of the normals remain in the faces; " + sizes;
    return "shapes shrink: with weights of 1 and 0.001 errors of normals add up over "
           "sqrt(2 beta / alpha) = 45 voxels, and no limit holds the vertices; " +
           sizes;
}

/// What surface nets pay for needing no normals.
std::string whyNets(const View& view) {
    return "surface nets use no normals, so noise does not reach them; they pay with distance: "
           "mean signed distance " +
           meanBias(view, "SN 16", 0);
}

void addNoise(const View& view, Verdicts& all) {
    for (const std::string& method : kOurs)
        for (const char* peer : {"MC", "DC", "DC in cell"}) {
            const std::string why = whyNoise(view, method);
            all.push_back(
                explained(smaller(view, method, peer, Measure::rms, "rms distance"), why));
            all.push_back(
                explained(smaller(view, method, peer, Measure::normalMean, "normal error"), why));
        }
    const std::string why = whyNets(view);
    all.push_back(explained(smaller(view, "studio", "SN 16", Measure::rms, "rms distance"), why));
    all.push_back(
        explained(smaller(view, "studio", "SN 16", Measure::normalMean, "normal error"), why));
}

void addLabels(const View& view, Verdicts& all) {
    for (const char* peer : {"MC", "DC", "SN 16", "studio"}) {
        const std::string why =
            "k = 0.4 and more leave pieces that no estimate of normals tells from the shape; mean "
            "normal error of `noisy` " +
            words(view.mean({.method = "noisy",
                             .level = view.levels().back(),
                             .measure = Measure::normalMean}),
                  1) +
            " at " + decimals(view.levels().back(), 1);
        all.push_back(explained(smaller(view, "noisy", peer, Measure::rms, "rms distance"), why));
        all.push_back(
            explained(smaller(view, "noisy", peer, Measure::normalMean, "normal error"), why));
    }
}

/// Why vertices do not come closer: how wrong the normals of the finest grid are.
std::string whyOrder(const View& view, const std::string& method) {
    const auto error = [&](int resolution) {
        return decimals(
            view.mean({.method = method, .measure = Measure::estimate, .resolution = resolution})
                .mean,
            2);
    };
    int finest = 0;
    for (const Sample& sample : view.samples())
        if (sample.method == method) finest = std::max(finest, sample.resolution);
    return "errors of the normals that are correlated over many voxels add up along the surface: "
           "they are off by " +
           error(kFine) + " degrees at " + std::to_string(kFine) + " and " + error(finest) +
           " at " + std::to_string(finest);
}

std::string whyCreases(const View& view, const std::string& method) {
    return "its normals are off by " +
           words(view.mean({.method = method, .measure = Measure::estimate}), 1) +
           " degrees 1 voxel and more from a crease";
}

std::string table(const std::string& title, const Verdicts& verdicts) {
    std::string text = "\n### " + title + "\n\n" + head({"claim", "figure", "verdict"});
    for (const Verdict& v : verdicts)
        text += row({v.claim, v.figure,
                     nameOf(v.outcome) + (v.why.empty() ? std::string() : ": " + v.why)});
    return text;
}

/// A table of verdicts on a section, or a line that says that it is missing.
std::string onSection(const Measured& measured, const std::string& section,
                      const std::string& title,
                      const std::function<void(const View&, Verdicts&)>& judge) {
    const auto found = measured.find(section);
    if (found == measured.end())
        return "\n### " + title + "\n\nNot measured: `./dev study " + section + "`.\n";
    Verdicts verdicts;
    judge(View(found->second), verdicts);
    return table(title, verdicts);
}

}  // namespace

std::string writeVerdicts(const Measured& measured) {
    std::string text =
        "\n## Verdicts\n\nEach verdict is computed from the figure beside it. Quotients are ours "
        "over theirs, the geometric mean over the shapes with its interval over the poses; "
        "*partly* also means that the whole interval is below 1, but a shape of its own is above "
        "it. `paper, auto normals` is the exact minimum of the paper's energy with the same "
        "normals as DC and `studio`.\n";
    text += onSection(measured, "normal-noise",
                      "\"Better than marching cubes and dual contouring under noise of the "
                      "normals\" (levels: degrees)",
                      addNoise);
    text +=
        onSection(measured, "position-noise", "\"Way more stable\" under noise of the positions",
                  [](const View& view, Verdicts& all) {
                      for (const std::string& method : kOurs) all.push_back(stable(view, method));
                  });
    text +=
        onSection(measured, "convergence", "Close to the shape in the l2 sense as h goes to 0",
                  [](const View& view, Verdicts& all) {
                      for (const char* method : {"paper", "paper, growing II", "studio", "organic"})
                          all.push_back(explained(converges(view, method), whyOrder(view, method)));
                      all.push_back(normalsConverge(view));
                  });
    text += onSection(measured, "creases", "Piecewise smooth", [](const View& view, Verdicts& all) {
        for (const char* method : {"paper", "AT", "guided", "studio"})
            all.push_back(explained(piecewiseSmooth(view, method), whyCreases(view, method)));
    });
    text += onSection(measured, "speed", "Speed", [](const View& view, Verdicts& all) {
        all.push_back(gradientStep(view));
        all.push_back(fewSteps(view, "gradient descent"));
        all.push_back(fewSteps(view, "accelerated"));
    });
    text += onSection(measured, "shapes", "What the limit of the displacement is for",
                      [&](const View& view, Verdicts& all) {
                          for (const char* method : {"paper", "paper, auto normals"})
                              all.push_back(explained(
                                  keepsSize(view, method),
                                  "fairness of 50 times the data weight pulls inwards, and no "
                                  "limit holds the vertices; worst on thin and cornered shapes"));
                          all.push_back(keepsSize(view, "studio"));
                          all.push_back(guarantees(measured));
                      });
    text +=
        onSection(measured, "label-noise",
                  "The preset `noisy` under noise of the labels (levels: probability)", addLabels);
    return text;
}

}  // namespace rivage::study
