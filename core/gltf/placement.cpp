#include "core/gltf/placement.h"

namespace rivage::core {
namespace {

Vec3d pivotOf(const Mesh& mesh, Pivot pivot) {
    const Vec3d& low = mesh.boxMin;
    Vec3d center = 0.5 * (low + mesh.boxMax);
    switch (pivot) {
        case Pivot::bottom: return {center.x(), center.y(), low.z()};
        case Pivot::center: return center;
        case Pivot::corner: return low;
        case Pivot::world: return Vec3d::Zero();
    }
    return Vec3d::Zero();
}

}  // namespace

Placement placementOf(const Mesh& mesh, const OutputOptions& options) {
    return {pivotOf(mesh, options.pivot), options.voxelSize, options.up};
}

}  // namespace rivage::core
