#include "core/formats/vox_scene_graph.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/formats/clean_text.h"
#include "core/formats/vox_nodes.h"

namespace rivage::core {
namespace {

constexpr std::int64_t kMaxTranslation = 1LL << 30;  // voxels; far outside every editor's world
constexpr std::uint64_t kStepsPerInstance = 4;       // nodes visited for one instance

/// The nodes with their ids resolved: `children` hold indices into the document's nodes.
struct Graph {
    const VoxDocument& document;
    std::vector<std::vector<std::uint32_t>> children;
    std::uint32_t root = 0;
};

std::string nodeField(const VoxNode& node) { return "/grid/nodes/" + std::to_string(node.id); }

Result<Graph> resolveIds(const VoxDocument& document) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> byId;
    byId.reserve(document.nodes.size());
    for (std::uint32_t i = 0; i < document.nodes.size(); ++i)
        byId.emplace_back(document.nodes[i].id, i);
    std::sort(byId.begin(), byId.end());
    for (std::size_t i = 1; i < byId.size(); ++i)
        if (byId[i].first == byId[i - 1].first)
            return voxError(
                "two nodes of the scene graph have the id " + std::to_string(byId[i].first),
                nodeField(document.nodes[byId[i].second]));
    if (byId.front().first != 0) return voxError("the scene graph has no node 0", "/grid/nodes/0");

    Graph graph{document, {}, byId.front().second};
    graph.children.resize(document.nodes.size());
    for (std::uint32_t i = 0; i < document.nodes.size(); ++i) {
        for (const std::uint32_t id : document.nodes[i].children) {
            const auto found = std::lower_bound(byId.begin(), byId.end(), std::pair(id, 0U));
            if (found == byId.end() || found->first != id)
                return voxError("a node of the scene graph refers to node " + std::to_string(id) +
                                    ", which does not exist",
                                nodeField(document.nodes[i]));
            graph.children[i].push_back(found->second);
        }
        for (const VoxShown& shown : document.nodes[i].shown)
            if (shown.model >= document.models.size())
                return fail(
                    Error{ErrorCode::malformedInput,
                          "a shape node shows model " + std::to_string(shown.model) +
                              ", and the file has " + std::to_string(document.models.size()),
                          nodeField(document.nodes[i]), document.models.size(), shown.model});
    }
    return graph;
}

/// Depth first with an explicit stack: a node that is reached while it is open closes a cycle.
Result<void> refuseCycles(const Graph& graph) {
    enum class State : std::uint8_t { fresh, open, done };
    std::vector<State> state(graph.children.size(), State::fresh);
    struct Step {
        std::uint32_t node;
        std::size_t next;
    };
    for (std::uint32_t start = 0; start < graph.children.size(); ++start) {
        if (state[start] != State::fresh) continue;
        std::vector<Step> path{{start, 0}};
        state[start] = State::open;
        while (!path.empty()) {
            Step& step = path.back();
            const auto& children = graph.children[step.node];
            if (step.next == children.size()) {
                state[step.node] = State::done;
                path.pop_back();
                continue;
            }
            const std::uint32_t child = children[step.next++];
            if (state[child] == State::open)
                return voxError("the scene graph is cyclic",
                                nodeField(graph.document.nodes[child]));
            if (state[child] == State::done) continue;
            state[child] = State::open;
            path.push_back({child, 0});
        }
    }
    return {};
}

/// A node to visit, with what its ancestors hand down.
struct Visit {
    std::uint32_t node = 0;
    Mat3i rotation = Mat3i::Identity();
    Vec3i translation = Vec3i::Zero();
    bool hidden = false;
    int layer = -1;
    std::string_view name;
};

/// What the children of a visited transform inherit.
Result<Visit> throughTransform(const VoxDocument& document, const VoxNode& node, Visit visit) {
    const Eigen::Matrix<std::int64_t, 3, 1> translation =
        visit.rotation.cast<std::int64_t>() * node.pose.translation.cast<std::int64_t>() +
        visit.translation.cast<std::int64_t>();
    if (translation.cwiseAbs().maxCoeff() > kMaxTranslation)
        return voxError("a translation of the scene graph is out of range", nodeField(node));
    visit.translation = translation.cast<int>();
    visit.rotation = visit.rotation * node.pose.rotation;
    visit.layer = node.layer;
    const auto layer = document.hiddenLayers.find(node.layer);
    visit.hidden = visit.hidden || (layer != document.hiddenLayers.end() && layer->second);
    return visit;
}

Instance instanceOf(const VoxNode& shape, const Visit& visit) {
    Instance instance;
    for (const VoxShown& shown : shape.shown) {
        instance.frames.push_back(static_cast<int>(shown.model));
        instance.frameTimes.push_back(shown.time);
    }
    instance.rotation = visit.rotation;
    instance.translation = visit.translation;
    instance.hidden = visit.hidden;
    instance.layer = visit.layer;
    instance.name = cleanText(visit.name);
    return instance;
}

tl::unexpected<Error> tooManyInstances(const Limits& limits) {
    return fail(Error{
        ErrorCode::tooLarge,
        "the scene graph unfolds to more than " + std::to_string(limits.maxModels) + " instances",
        "/grid/nodes", limits.maxModels, std::nullopt, "--max-models"});
}

Result<std::vector<Instance>> unfold(const Graph& graph, const Limits& limits) {
    const std::uint64_t maxSteps = kStepsPerInstance * limits.maxModels + graph.children.size();
    std::vector<Instance> instances;
    std::vector<Visit> stack{{.node = graph.root}};
    std::uint64_t steps = 1;
    std::uint64_t frames = 0;
    while (!stack.empty()) {
        Visit visit = stack.back();
        stack.pop_back();
        const VoxNode& node = graph.document.nodes[visit.node];
        visit.hidden = visit.hidden || node.hidden;
        if (!node.name.empty()) visit.name = node.name;
        if (node.kind == VoxNodeKind::shape) {
            frames += node.shown.size();
            if (instances.size() >= limits.maxModels || frames > maxSteps)
                return tooManyInstances(limits);
            instances.push_back(instanceOf(node, visit));
            continue;
        }
        if (node.kind == VoxNodeKind::transform) {
            Result<Visit> inner = throughTransform(graph.document, node, visit);
            if (!inner) return fail(std::move(inner.error()));
            visit = *inner;
        }
        const auto& children = graph.children[visit.node];
        steps += children.size();
        if (steps > maxSteps) return tooManyInstances(limits);
        for (auto child = children.rbegin(); child != children.rend(); ++child) {
            visit.node = *child;
            stack.push_back(visit);
        }
    }
    return instances;
}

}  // namespace

Result<std::vector<Instance>> expandSceneGraph(const VoxDocument& document, const Limits& limits) {
    if (document.nodes.empty()) {
        Instance instance;
        for (std::size_t i = 0; i < document.models.size(); ++i)
            instance.frames.push_back(static_cast<int>(i));
        instance.centered = false;
        if (instance.frames.empty()) return std::vector<Instance>{};
        return std::vector<Instance>{instance};
    }
    const Result<Graph> graph = resolveIds(document);
    if (!graph) return fail(graph.error());
    if (const Result<void> acyclic = refuseCycles(*graph); !acyclic) return fail(acyclic.error());
    return unfold(*graph, limits);
}

}  // namespace rivage::core
