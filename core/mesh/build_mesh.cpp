#include "core/mesh/build_mesh.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/mesh/diagonal.h"
#include "core/mesh/patch.h"
#include "core/mesh/shading.h"
#include "core/mesh/styles.h"

namespace rivage::core {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

// What the faces of one part have beside their places: shared points, normals and styles.
struct PartData {
    Patch patch;
    CornerGroups points;
    CornerGroups shading;        // corners that share a normal; refines `points`
    std::vector<Vec3f> normals;  // one a shading group; empty for flat shading
    std::vector<FaceStyle> styles;
};

std::string labelName(const VoxelGrid& grid, Label label) {
    if (label == Label{0}) return "background";
    const std::string& name = grid.labels[label];
    return name.empty() ? "label " + std::to_string(index(label)) : name;
}

MeshPart emptyPart(const VoxelGrid& grid, const LabelPair& labels) {
    MeshPart part;
    part.inner = labelName(grid, labels.inner);
    part.outer = labelName(grid, labels.outer);
    part.name = labels.outer == Label{0} ? part.inner : part.inner + " | " + part.outer;
    return part;
}

PartData preparePart(const DigitalSurface& surface, const IdVector<PointelId, Vec3d>& positions,
                     Patch patch, Shading shading, const Workers& workers) {
    PartData data{.patch = std::move(patch)};
    data.points = groupFans(data.patch, {}, workers);
    data.shading = data.points;
    if (shading == Shading::flat) return data;
    const std::vector<Vec3d> areas = vectorAreas(data.patch, surface, positions, workers);
    if (shading == Shading::crease)
        data.shading =
            groupFans(data.patch, smoothEdges(data.patch, surface, areas, workers), workers);
    data.normals = groupNormals(data.patch, surface, positions, areas, data.shading, workers);
    return data;
}

// Fills the primitives of one part. A vertex is one combination of shading group, primitive and
// colour; the vertices of a group form a chain, which is short, so no hash map is needed.
class PartFiller {
public:
    PartFiller(const PartData& data, const Vec3d& offset, Colors colors, MeshPart& part)
        : data_(data),
          offset_(offset),
          colors_(colors),
          part_(part),
          head_(data.shading.count, kNoVertex) {
        preparePrimitives();
    }

    void addFace(std::uint32_t face, const DigitalSurface& surface,
                 const IdVector<PointelId, Vec3d>& positions) {
        const auto& corners = surface.corners[data_.patch.surfels[face]];
        const FaceStyle& style = data_.styles[face];
        const std::uint32_t slot = slotOf_[style.material];
        const std::uint32_t start = firstCorner(corners, positions);
        Quad quad{};
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t k = (start + i) & 3U;
            quad[i] = vertex(4 * face + k, positions[corners[k]], slot, style.color);
        }
        part_.primitives[slot].quads.push_back(quad);
    }

private:
    struct Link {
        Rgba16 color;
        std::uint32_t slot;
        std::uint32_t vertex;  // in its primitive
        std::uint32_t next;
    };

    void preparePrimitives() {
        std::vector<std::uint32_t> used;
        for (const FaceStyle& style : data_.styles) {
            if (slotOf_.size() <= style.material) slotOf_.resize(style.material + 1, kNoVertex);
            if (slotOf_[style.material] == kNoVertex) used.push_back(style.material);
            slotOf_[style.material] = 0;
        }
        std::sort(used.begin(), used.end());
        part_.primitives.resize(used.size());
        for (std::uint32_t slot = 0; slot < used.size(); ++slot) {
            slotOf_[used[slot]] = slot;
            part_.primitives[slot].material = used[slot];
        }
    }

    std::uint32_t vertex(std::uint32_t corner, const Vec3d& position, std::uint32_t slot,
                         const Rgba16& color) {
        const std::uint32_t group = data_.shading.of[corner];
        for (std::uint32_t i = head_[group]; i != kNoVertex; i = links_[i].next)
            if (links_[i].slot == slot && links_[i].color == color) return links_[i].vertex;
        MeshPrimitive& primitive = part_.primitives[slot];
        const auto made = static_cast<std::uint32_t>(primitive.positions.size());
        primitive.positions.push_back(position + offset_);
        primitive.points.push_back(data_.points.of[corner]);
        if (!data_.normals.empty()) primitive.normals.push_back(data_.normals[group]);
        if (colors_ != Colors::none) primitive.colors.push_back(color);
        links_.push_back({color, slot, made, head_[group]});
        head_[group] = static_cast<std::uint32_t>(links_.size() - 1);
        return made;
    }

    const PartData& data_;
    Vec3d offset_;
    Colors colors_;
    MeshPart& part_;
    std::vector<std::uint32_t> slotOf_;  // primitive of each output material
    std::vector<std::uint32_t> head_;    // first link of each shading group
    std::vector<Link> links_;
};

void setBox(const VoxelGrid& grid, Mesh& mesh) {
    const Vec3i end = grid.origin + grid.voxels.size();
    mesh.boxMin = grid.origin.cast<double>().cwiseProduct(grid.spacing);
    mesh.boxMax = end.cast<double>().cwiseProduct(grid.spacing);
}

}  // namespace

Result<Mesh> buildMesh(const VoxelGrid& grid, const DigitalSurface& surface,
                       const SurfelLinks& links, const IdVector<PointelId, Vec3d>& positions,
                       const OutputOptions& output, const RunContext& run) {
    constexpr std::uint32_t kMaxFaces = 1U << 30;  // four corners a face have 32-bit numbers
    Mesh mesh;
    setBox(grid, mesh);
    Styles styles(grid, output.colors);
    const auto ranks = ranksInInterface(surface, run);
    for (std::uint32_t i = 0; i < surface.interfaces.size(); ++i) {
        const Interface& sheet = surface.interfaces[InterfaceId{i}];
        if (sheet.begin == sheet.end) continue;
        if (output.parts == Parts::exterior && sheet.labels.outer != Label{0}) continue;
        if (run.stopped()) return fail(run.stopError());
        if (sheet.end - sheet.begin >= kMaxFaces)
            return fail({.code = ErrorCode::outputTooLarge,
                         .message = "one part of the mesh has too many faces",
                         .limit = kMaxFaces - 1,
                         .actual = sheet.end - sheet.begin});
        Patch patch = buildPatch(surface, InterfaceId{i}, links, ranks, run);
        PartData data = preparePart(surface, positions, std::move(patch), output.shading, run);
        if (run.stopped()) return fail(run.stopError());
        data.styles.reserve(data.patch.faceCount());
        serialFor(data.patch.faceCount(), run, [&](std::size_t face) {
            data.styles.push_back(styles.of(surface, data.patch.surfels[face]));
        });
        if (run.stopped()) return fail(run.stopError());

        MeshPart part = emptyPart(grid, sheet.labels);
        PartFiller filler(data, mesh.boxMin, output.colors, part);
        const bool filled = serialFor(data.patch.faceCount(), run, [&](std::size_t face) {
            filler.addFace(static_cast<std::uint32_t>(face), surface, positions);
        });
        if (!filled) return fail(run.stopError());
        mesh.parts.push_back(std::move(part));
    }
    mesh.materials = styles.takeMaterials();
    return mesh;
}

}  // namespace rivage::core
