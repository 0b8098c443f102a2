#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "tests/study/peers.h"

namespace rivage::study {
namespace {

constexpr int kCorners = 8;  // of a cell; bit k of the number is the step along axis k

/// An edge of a cell: it leaves `corner` along `axis`.
struct CellEdge {
    int corner;
    int axis;
    auto operator<=>(const CellEdge&) const = default;
};

CellEdge edgeBetween(int a, int b) {
    const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
    return {std::min(a, b), axis};
}

/// The polygons of a cell whose inner corners are the bits of `inner`, as loops of edges,
/// counter-clockwise seen from outside the label.
std::vector<std::vector<CellEdge>> polygonsOf(unsigned inner) {
    const auto isInner = [&](int corner) { return (inner >> corner & 1) != 0; };
    std::map<CellEdge, CellEdge> next;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            const int u = 1 << (axis + 1) % 3;
            const int v = 1 << (axis + 2) % 3;
            const int base = side << axis;
            // Counter-clockwise seen from outside the cell.
            std::array<int, 4> ring = {base, base + u, base + u + v, base + v};
            if (side == 0) std::swap(ring[1], ring[3]);
            // A run of inner corners is cut off by a segment from the edge behind its last corner
            // to the edge before its first one.
            for (int k = 0; k < 4; ++k) {
                if (!isInner(ring[k]) || isInner(ring[(k + 3) % 4])) continue;
                int last = k;
                while (isInner(ring[(last + 1) % 4])) ++last;
                const CellEdge from = edgeBetween(ring[(k + 3) % 4], ring[k]);
                const CellEdge to = edgeBetween(ring[last % 4], ring[(last + 1) % 4]);
                next[from] = to;
            }
        }
    std::vector<std::vector<CellEdge>> polygons;
    while (!next.empty()) {
        std::vector<CellEdge>& loop = polygons.emplace_back();
        CellEdge edge = next.begin()->first;
        for (auto found = next.find(edge); found != next.end(); found = next.find(edge)) {
            loop.push_back(edge);
            edge = found->second;
            next.erase(found);
        }
    }
    return polygons;
}

const std::vector<std::vector<CellEdge>>& polygonTable(unsigned inner) {
    static const auto table = [] {
        std::array<std::vector<std::vector<CellEdge>>, 1U << kCorners> all;
        for (unsigned k = 0; k < all.size(); ++k) all[k] = polygonsOf(k);
        return all;
    }();
    return table[inner];
}

class Builder {
public:
    Builder(const VoxelGrid& grid, const DigitalSurface& surface, const Crossings& crossings)
        : grid_(grid), surface_(surface) {
        mesh_.vertices = crossings.raw();  // those of the surfels, which cells share
    }

    /// The cell whose middle is a pointel: its corners are the centres of the voxels around.
    void addCell(PointelId p) {
        const Vec3i low = surface_.pointels[p] - Vec3i::Ones();
        std::array<Label, kCorners> labels;
        for (int c = 0; c < kCorners; ++c)
            labels[c] = grid_.labelAt(low + Vec3i(c & 1, c >> 1 & 1, c >> 2 & 1));
        std::array<Label, kCorners> present = labels;
        std::sort(present.begin(), present.end());
        const auto end = std::unique(present.begin(), present.end());
        for (auto label = present.begin(); label != end; ++label)
            if (*label != Label{0}) addLabel(p, labels, *label);
    }

    StudyMesh take() { return std::move(mesh_); }

private:
    void addLabel(PointelId p, const std::array<Label, kCorners>& labels, Label label) {
        unsigned inner = 0;
        for (int c = 0; c < kCorners; ++c) inner |= (labels[c] == label ? 1U : 0U) << c;
        for (const auto& polygon : polygonTable(inner))
            for (std::size_t k = 2; k < polygon.size(); ++k)
                addTriangle(p, labels, label, {polygon[0], polygon[k - 1], polygon[k]});
    }

    void addTriangle(PointelId p, const std::array<Label, kCorners>& labels, Label label,
                     const std::array<CellEdge, 3>& edges) {
        std::array<std::uint32_t, 4> corners{};
        std::array<Label, 3> others{};
        for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = index(surfelOf(p, edges[k]));
            const Label low = labels[edges[k].corner];
            others[k] = low == label ? labels[edges[k].corner | 1 << edges[k].axis] : low;
        }
        corners[3] = corners[2];
        const Label other = others[1] == others[2] ? others[1] : others[0];
        const bool isInner = other == Label{0} || label < other;
        if (!isInner) std::swap(corners[0], corners[1]);
        mesh_.faces.push_back(
            {corners, isInner ? LabelPair{label, other} : LabelPair{other, label}});
    }

    /// The surfel that an edge of the cell around a pointel crosses.
    [[nodiscard]] SurfelId surfelOf(PointelId p, const CellEdge& edge) const {
        // The edge between two voxels along `axis` crosses the surfel in the plane of the pointel;
        // its lowest corner is one step down along the axes where the edge lies low.
        PointelId lowest = p;
        for (int axis = 0; axis < 3; ++axis)
            if (axis != edge.axis && (edge.corner >> axis & 1) == 0)
                lowest = surface_.neighbours[lowest][2 * axis];
        return surface_.surfelAt(lowest, edge.axis);
    }

    const VoxelGrid& grid_;
    const DigitalSurface& surface_;
    StudyMesh mesh_;
};

}  // namespace

StudyMesh marchingCubes(const VoxelGrid& grid, const DigitalSurface& surface,
                        const Crossings& crossings) {
    Builder builder(grid, surface, crossings);
    for (std::uint32_t i = 0; i < surface.pointelCount(); ++i) builder.addCell(PointelId{i});
    return builder.take();
}

}  // namespace rivage::study
