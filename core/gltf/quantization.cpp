#include "core/gltf/quantization.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace rivage::core {
namespace {

constexpr double kStepsPerVoxel = 128;
constexpr int kMinBits = 11;
constexpr int kMaxBits = 20;

}  // namespace

Quantization quantizationOf(const Mesh& mesh, const Placement& placement,
                            const OutputOptions& options, const RunContext& run) {
    // The box starts as that of the voxels, so the grid does not depend on small displacements.
    Vec3d low = mesh.boxMin;
    Vec3d high = mesh.boxMax;
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives)
            serialFor(primitive.positions.size(), run, [&](std::size_t v) {
                low = low.cwiseMin(primitive.positions[v]);
                high = high.cwiseMax(primitive.positions[v]);
            });
    low = low.array().floor();
    high = high.array().ceil();
    const double extent = std::max(1.0, (high - low).maxCoeff());
    const int needed = static_cast<int>(std::ceil(std::log2(extent * kStepsPerVoxel + 1)));

    Quantization grid;
    grid.bits = options.dracoPositionBits.value_or(std::clamp(needed, kMinBits, kMaxBits));
    const double steps = static_cast<double>((1U << grid.bits) - 1);
    const bool exact = !options.dracoPositionBits && needed <= kMaxBits;
    const double voxels = exact ? steps / kStepsPerVoxel : extent;
    // Float rounding of the corner must not push the last position outside.
    grid.range = static_cast<float>(voxels * placement.scale * (exact ? 1 : 1 + 1e-6));
    const Vec3f corner = placement.position(low).cwiseMin(placement.position(high));
    grid.origin = {corner.x(), corner.y(), corner.z()};
    return grid;
}

}  // namespace rivage::core
