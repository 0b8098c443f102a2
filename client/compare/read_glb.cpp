#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "client/compare/glb_primitive.h"

namespace rivage::client {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using proto::Json;

/// So many numbers of a member; false if it has others.
template <std::size_t count>
bool readNumbers(const Json& array, std::array<double, count>& values) {
    if (array.is_null()) return true;
    if (!array.is_array() || array.size() != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
        if (!array[i].is_number()) return false;
        values[i] = array[i].get<double>();
    }
    return true;
}

/// How a node places what is below it.
Outcome<Matrix4d> placementOf(const Json& node) {
    std::array<double, 16> matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    std::array<double, 3> shift{};
    std::array<double, 4> turn{0, 0, 0, 1};
    std::array<double, 3> scale{1, 1, 1};
    if (!readNumbers(memberOf(node, "matrix"), matrix) ||
        !readNumbers(memberOf(node, "translation"), shift) ||
        !readNumbers(memberOf(node, "rotation"), turn) ||
        !readNumbers(memberOf(node, "scale"), scale))
        return malformed("a node has no proper placement");
    if (!memberOf(node, "matrix").is_null()) return Matrix4d(Eigen::Map<Matrix4d>(matrix.data()));
    const Eigen::Quaterniond rotation(turn[3], turn[0], turn[1], turn[2]);
    if (!(rotation.norm() > 0)) return malformed("a node has no proper rotation");
    Eigen::Affine3d placement = Eigen::Affine3d::Identity();
    placement.translate(Vector3d(shift[0], shift[1], shift[2]));
    placement.rotate(rotation.normalized());
    placement.scale(Vector3d(scale[0], scale[1], scale[2]));
    return placement.matrix();
}

class GlbReader {
public:
    GlbReader(const GlbDocument& document, const SurfaceLimits& limits)
        : document_(document), limits_(limits) {}

    Outcome<Surface> read() {
        surface_.format = "glb";
        surface_.bytes["json"] = document_.jsonBytes();
        surface_.materials = memberOf(document_.json(), "materials").size();
        const Json& extras = memberOf(memberOf(document_.json(), "asset"), "extras");
        surface_.report = memberOf(extras, "rivage");
        if (auto done = readScene(); !done) return tl::unexpected(done.error());
        if (!colored_) surface_.colors.clear();
        return std::move(surface_);
    }

private:
    struct Step {
        const Json* index;
        Matrix4d placement;
    };

    /// Walks the nodes in the order of the file. No recursion: a file may nest them deeply.
    Outcome<void> readScene() {
        const Json first = 0;
        const Json& chosen = memberOf(document_.json(), "scene");
        const auto scene = document_.element("scenes", chosen.is_null() ? first : chosen);
        if (!scene) return tl::unexpected(scene.error());
        std::vector<bool> seen(memberOf(document_.json(), "nodes").size());
        std::vector<Step> steps;
        const auto twice = [] { return malformed("a node is below two others"); };
        if (!push(memberOf(**scene, "nodes"), Matrix4d::Identity(), steps)) return twice();
        while (!steps.empty()) {
            const Step step = steps.back();
            steps.pop_back();
            const auto node = document_.element("nodes", *step.index);
            if (!node) return tl::unexpected(node.error());
            const std::size_t number = *wholeOf(*step.index);
            if (seen[number]) return twice();
            seen[number] = true;
            const auto own = placementOf(**node);
            if (!own) return tl::unexpected(own.error());
            const Matrix4d placement = step.placement * *own;
            if (auto done = readNode(**node, placement); !done) return done;
            if (!push(memberOf(**node, "children"), placement, steps)) return twice();
        }
        return {};
    }

    /// @return false if more nodes are named than there are, so that one is named twice
    bool push(const Json& nodes, const Matrix4d& placement, std::vector<Step>& steps) {
        if (!nodes.is_array()) return true;
        named_ += nodes.size();
        if (named_ > memberOf(document_.json(), "nodes").size()) return false;
        for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
            steps.push_back({&*node, placement});
        return true;
    }

    Outcome<void> readNode(const Json& node, const Matrix4d& placement) {
        const Json& index = memberOf(node, "mesh");
        if (index.is_null()) return {};
        const auto mesh = document_.element("meshes", index);
        if (!mesh) return tl::unexpected(mesh.error());
        const Json& primitives = memberOf(**mesh, "primitives");
        if (!primitives.is_array()) return malformed("a mesh has no primitives");
        SurfacePart part{textOf(node, "name"), surface_.triangles.size()};
        if (part.name.empty()) part.name = textOf(**mesh, "name");
        for (const Json& primitive : primitives) {
            if (!primitive.is_object()) return malformed("a primitive is no object");
            if (auto done = addPrimitive(primitive, placement); !done) return done;
        }
        part.count = surface_.triangles.size() - part.first;
        if (part.count > 0) surface_.parts.push_back(std::move(part));
        return {};
    }

    /// The colour by which a material multiplies those of the vertices.
    Outcome<Vector3f> materialColor(const Json& primitive) {
        const Json& index = memberOf(primitive, "material");
        if (index.is_null()) return Vector3f::Ones();
        const auto material = document_.element("materials", index);
        if (!material) return tl::unexpected(material.error());
        std::array<double, 4> factor{1, 1, 1, 1};
        const Json& pbr = memberOf(**material, "pbrMetallicRoughness");
        if (!readNumbers(memberOf(pbr, "baseColorFactor"), factor))
            return malformed("a material has no proper colour");
        colored_ = colored_ || !memberOf(pbr, "baseColorFactor").is_null();
        return Vector3d(factor[0], factor[1], factor[2]).cast<float>();
    }

    Outcome<void> addPrimitive(const Json& primitive, const Matrix4d& placement) {
        const auto color = materialColor(primitive);
        if (!color) return tl::unexpected(color.error());
        const GlbRoom room{limits_.maxTriangles - surface_.triangles.size(),
                           limits_.maxVertices - surface_.positions.size()};
        const auto read = readPrimitive(document_, primitive, room);
        if (!read) return tl::unexpected(read.error());
        ++surface_.primitives;
        for (const auto& [name, bytes] : read->bytes.items()) {
            const Json& before = memberOf(surface_.bytes, name.c_str());
            surface_.bytes[name] = wholeOf(before).value_or(0) + bytes.get<std::uint64_t>();
            if (name == "draco") surface_.format = "glb with draco";
        }
        return append(*read, *color, placement);
    }

    Outcome<void> append(const GlbPrimitive& read, const Vector3f& color,
                         const Matrix4d& placement) {
        const auto first = static_cast<std::uint32_t>(surface_.positions.size());
        const Eigen::Matrix3d linear = placement.topLeftCorner<3, 3>();
        const Vector3d shift = placement.topRightCorner<3, 1>();
        for (std::size_t v = 0; v < read.positions.size(); ++v) {
            const Vector3f position =
                (linear * read.positions[v].cast<double>() + shift).cast<float>();
            if (!position.allFinite()) return malformed("a position is not finite");
            const Vector3f own = read.colors.empty() ? Vector3f::Ones() : read.colors[v];
            if (!own.allFinite()) return malformed("a colour is not finite");
            surface_.positions.push_back(position);
            surface_.colors.emplace_back(own.cwiseProduct(color));
        }
        colored_ = colored_ || !read.colors.empty();
        const bool mirrored = linear.determinant() < 0;  // glTF turns the faces then
        for (auto triangle : read.triangles) {
            for (std::uint32_t& v : triangle) v += first;
            if (mirrored) std::swap(triangle[1], triangle[2]);
            surface_.triangles.push_back(triangle);
        }
        return {};
    }

    const GlbDocument& document_;
    const SurfaceLimits& limits_;
    Surface surface_;
    std::size_t named_ = 0;  ///< nodes
    bool colored_ = false;
};

}  // namespace

Outcome<Surface> readGlb(const std::string& bytes, const SurfaceLimits& limits) {
    const auto document = GlbDocument::open(bytes, limits);
    if (!document) return tl::unexpected(document.error());
    auto surface = GlbReader(*document, limits).read();
    if (surface) surface->bytes["file"] = bytes.size();
    return surface;
}

}  // namespace rivage::client
