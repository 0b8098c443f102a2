#include "tests/study/sections.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "tests/study/bodies.h"

namespace rivage::study {
namespace {

using Names = std::vector<std::string>;

/// One grid and what is run on it.
struct Task {
    std::string shape;
    int resolution;
    int pose;
    double level = 0;
    double labelNoise = 0;
    Disturbance disturbance;
    MeasureOptions measures;
    std::vector<Method> methods;
};

const Names kNoiseShapes = {"sphere", "torus",   "goursat", "capsule",
                            "box",    "fandisk", "sectors", "foam"};
const Names kQuickShapes = {"sphere", "box", "sectors"};

std::vector<Method> methodsOf(const Names& names) {
    std::vector<Method> methods;
    for (const std::string& name : names) methods.push_back(method(name));
    return methods;
}

/// The shapes of a section in all poses.
std::vector<Task> tasksFor(const Names& shapes, const Effort& scale, const Names& methods) {
    std::vector<Task> tasks;
    for (const std::string& shape : scale.quick ? kQuickShapes : shapes)
        for (int p = 0; p < scale.poses; ++p) {
            Task task{.shape = shape, .resolution = scale.resolution, .pose = p};
            task.disturbance.seed = 100 + static_cast<std::uint32_t>(p);
            task.measures.thorough = true;
            task.methods = methodsOf(methods);
            tasks.push_back(std::move(task));
        }
    return tasks;
}

/// `tasks` once for each level; `set(task, level)` says what it means.
template <typename Set>
std::vector<Task> atLevels(const std::vector<Task>& tasks, const std::vector<double>& levels,
                           const Set& set) {
    std::vector<Task> all;
    for (const Task& task : tasks)
        for (const double level : levels) {
            all.push_back(task);
            all.back().level = level;
            set(all.back(), level);
        }
    return all;
}

Names allShapes() {
    Names names;
    for (const Body& one : bodies()) names.push_back(one.name);
    return names;
}

Names creasedShapes() {
    Names names;
    for (const Body& one : bodies())
        if (one.creased) names.push_back(one.name);
    return names;
}

std::vector<Task> shapeTasks(const Effort& scale) {
    std::vector<Task> tasks =
        tasksFor(allShapes(), scale,
                 {"raw", "MC", "DC", "DC in cell", "SN", "SN 16", "paper", "paper, auto normals",
                  "studio", "architectural", "organic", "noisy"});
    for (Task& task : tasks) task.measures.bothWays = true;
    return tasks;
}

std::vector<Task> creaseTasks(const Effort& scale) {
    Effort creased = scale;
    creased.quick = false;
    std::vector<Task> tasks = tasksFor(scale.quick ? Names{"box"} : creasedShapes(), creased,
                                       {"MC", "DC", "DC in cell", "SN 16", "paper", "studio",
                                        "guided", "AT", "II", "organic", "architectural"});
    for (Task& task : tasks) task.measures.thorough = false;
    return tasks;
}

std::vector<Task> normalTasks(const Effort& scale) {
    const std::vector<double> levels =
        scale.quick ? std::vector<double>{0, 20} : std::vector<double>{0, 5, 10, 20, 40};
    return atLevels(tasksFor(kNoiseShapes, scale,
                             {"MC", "DC", "DC in cell", "SN", "SN 16", "paper, auto normals",
                              "studio", "studio, no limit"}),
                    levels, [](Task& task, double level) { task.disturbance.normalTilt = level; });
}

std::vector<Task> positionTasks(const Effort& scale) {
    const std::vector<double> levels =
        scale.quick ? std::vector<double>{0, 0.5} : std::vector<double>{0, 0.1, 0.25, 0.5};
    return atLevels(
        tasksFor(kNoiseShapes, scale,
                 {"raw", "MC", "DC", "DC in cell", "SN", "SN 16", "paper, auto normals", "studio"}),
        levels, [](Task& task, double level) { task.disturbance.positionNoise = level; });
}

std::vector<Task> labelTasks(const Effort& scale) {
    constexpr std::size_t kLeastPart = 40;  // smaller parts are specks of noise
    const std::vector<double> levels =
        scale.quick ? std::vector<double>{0.2} : std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5};
    std::vector<Task> tasks = tasksFor(
        kNoiseShapes, scale, {"MC", "DC", "DC in cell", "SN 16", "paper", "studio", "noisy"});
    for (Task& task : tasks) task.measures.leastPart = kLeastPart;
    return atLevels(tasks, levels, [](Task& task, double level) { task.labelNoise = level; });
}

/// The paper's energy, and ours, with integral invariants whose radius grows as the theorem of
/// their convergence asks: R = k h^(1/3), in voxels h^(-2/3).
std::vector<Method> growingMethods(int resolution) {
    constexpr double kRadius = 3;  // at 16^3, as the paper's
    NormalOptions normals{.method = NormalMethod::integralInvariant,
                          .radius = kRadius * std::pow(resolution / 16.0, 2.0 / 3)};
    Method paper = method("paper");
    paper.name = "paper, growing II";
    paper.options.normals = normals;
    Method studio = method("studio");
    studio.name = "studio, growing II";
    studio.options.normals = normals;
    return {paper, studio};
}

std::vector<Task> convergenceTasks(const Effort& scale) {
    constexpr int kLargestGrowing = 128;  // balls of 19 voxels take minutes at 256
    const std::vector<int> resolutions = {256, 128, 64, 32, 16};  // the long ones first
    std::vector<Task> tasks;
    for (const int resolution : resolutions) {
        if (resolution > scale.largest) continue;
        Effort one = scale;
        one.resolution = resolution;
        one.quick = false;
        one.poses = std::min(scale.poses, resolution == 256 ? 2 : resolution == 128 ? 4 : 8);
        const Names shapes = scale.quick ? Names{"sphere", "torus"}
                                         : Names{"sphere", "torus", "goursat", "rounded cube"};
        for (Task& task : tasksFor(shapes, one,
                                   {"raw", "MC", "DC", "SN 16", "paper", "paper, auto normals",
                                    "studio", "organic"})) {
            task.measures.thorough = false;
            if (resolution <= kLargestGrowing)
                for (Method& growing : growingMethods(resolution))
                    task.methods.push_back(std::move(growing));
            tasks.push_back(std::move(task));
        }
    }
    return tasks;
}

std::vector<Task> tasksOf(const std::string& section, const Effort& scale) {
    if (section == "shapes") return shapeTasks(scale);
    if (section == "normal-noise") return normalTasks(scale);
    if (section == "position-noise") return positionTasks(scale);
    if (section == "label-noise") return labelTasks(scale);
    if (section == "creases") return creaseTasks(scale);
    return convergenceTasks(scale);
}

Samples run(const Task& task) {
    const Shape clean =
        digitize(body(task.shape), task.resolution, pose(static_cast<std::uint32_t>(task.pose)));
    const Shape shape =
        task.labelNoise > 0 ? withLabelNoise(clean, task.labelNoise, task.disturbance.seed) : clean;
    MeasureOptions measures = task.measures;
    if (task.labelNoise > 0) measures.clean = &clean.grid;
    Bench bench(shape.grid, task.disturbance);
    Samples samples;
    for (const Method& one : task.methods) {
        const Outcome outcome = bench.run(one);
        samples.push_back({task.shape, task.resolution, task.pose, one.name, task.level,
                           measure(shape, outcome, measures), outcome.milliseconds});
    }
    return samples;
}

}  // namespace

const std::vector<std::string>& sectionNames() {
    static const Names names = {"shapes",  "normal-noise", "position-noise", "label-noise",
                                "creases", "convergence",  "speed"};
    return names;
}

Samples runSection(const std::string& name, const Effort& scale) {
    if (name == "speed") return runSpeed();
    const std::vector<Task> tasks = tasksOf(name, scale);
    std::vector<Samples> results(tasks.size());
    (void)body("sphere");  // the shapes and methods are made before threads ask for them
    parallelBlocks(tasks.size(), 1, scale.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) results[i] = run(tasks[i]);
    });
    Samples all;
    for (Samples& samples : results)
        all.insert(all.end(), std::make_move_iterator(samples.begin()),
                   std::make_move_iterator(samples.end()));
    return all;
}

}  // namespace rivage::study
