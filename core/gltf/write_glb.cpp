#include "core/gltf/write_glb.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iterator>
#include <limits>
#include <new>
#include <utility>

#include "core/base/parallel.h"
#include "core/gltf/chunks.h"
#include "core/gltf/draco_primitive.h"
#include "core/gltf/glb_model.h"
#include "core/gltf/json_value.h"
#include "core/gltf/mesh_checks.h"
#include "core/gltf/placement.h"
#include "core/gltf/quantization.h"

namespace rivage::core {
namespace {

using DracoPrimitives = std::vector<Result<DracoPrimitive>>;

std::vector<const MeshPrimitive*> allPrimitives(const Mesh& mesh) {
    std::vector<const MeshPrimitive*> primitives;
    for (const MeshPart& part : mesh.parts)
        for (const MeshPrimitive& primitive : part.primitives) primitives.push_back(&primitive);
    return primitives;
}

// Bytes that the plain buffers of a mesh take, up to padding.
std::uint64_t plainBytes(const Mesh& mesh) {
    std::uint64_t bytes = 0;
    for (const MeshPrimitive* primitive : allPrimitives(mesh))
        bytes += 12 * primitive->positions.size() + 12 * primitive->normals.size() +
                 8 * primitive->colors.size() +
                 6 * primitive->quads.size() * (primitive->positions.size() <= 65535 ? 2 : 4);
    return bytes;
}

// The lengths in a GLB are 32-bit numbers.
std::uint64_t byteLimit(const RunContext& run) {
    return std::min<std::uint64_t>(run.limits.maxOutputBytes,
                                   std::numeric_limits<std::uint32_t>::max());
}

Result<void> checkSize(std::uint64_t bytes, const RunContext& run) {
    return checkOutputBytes(bytes, byteLimit(run));
}

// A stream is encoded in one go, so its size bounds how soon a stop is noticed: 80 ms.
constexpr std::size_t kMostQuads = 32768;

/// What is encoded as one stream; no quads: all of the primitive.
struct DracoTask {
    const MeshPrimitive* primitive;
    Chunk quads;
};

std::vector<DracoTask> dracoTasks(const MeshPart& part, const RunContext& run) {
    std::vector<DracoTask> tasks;
    for (const MeshPrimitive& primitive : part.primitives) {
        if (primitive.quads.size() <= kMostQuads)
            tasks.push_back({&primitive, {}});
        else
            for (Chunk& quads : cutQuads(primitive, kMostQuads, run))
                tasks.push_back({&primitive, std::move(quads)});
    }
    return tasks;
}

Result<void> addDracoParts(const Mesh& mesh, const Placement& placement,
                           const OutputOptions& options, const RunContext& run, GlbModel& model) {
    const Quantization grid = quantizationOf(mesh, placement, options, run);
    std::vector<DracoTask> tasks;
    std::vector<std::size_t> ends;
    for (const MeshPart& part : mesh.parts) {
        std::vector<DracoTask> own = dracoTasks(part, run);
        std::move(own.begin(), own.end(), std::back_inserter(tasks));
        ends.push_back(tasks.size());
    }
    DracoPrimitives encoded(tasks.size());
    const auto encodeOne = [&](std::size_t i) {
        const auto& [primitive, quads] = tasks[i];
        encoded[i] = quads.empty() ? encodeDraco(*primitive, placement, grid, options.dracoSpeed)
                                   : encodeDraco(chunkOf(*primitive, quads), placement, grid,
                                                 options.dracoSpeed);
    };
    if (!parallelFor(tasks.size(), run, encodeOne, 1)) return fail(run.stopError());
    std::uint64_t bytes = 0;
    for (const Result<DracoPrimitive>& one : encoded) {
        if (!one) return fail(one.error());
        bytes += one->bytes.size();
    }
    if (auto fits = checkSize(bytes, run); !fits) return fits;
    model.reserve(bytes + 3 * encoded.size());
    std::size_t next = 0;
    for (std::size_t p = 0; p < mesh.parts.size(); ++p) {
        model.beginPart(mesh.parts[p]);
        for (; next < ends[p]; ++next)
            model.addDraco(*encoded[next], tasks[next].primitive->material);
    }
    return {};
}

Result<void> addPlainParts(const Mesh& mesh, const Placement& placement, const RunContext& run,
                           GlbModel& model) {
    const std::uint64_t bytes = plainBytes(mesh);
    if (auto fits = checkSize(bytes, run); !fits) return fits;
    model.reserve(bytes);
    for (const MeshPart& part : mesh.parts) {
        model.beginPart(part);
        for (const MeshPrimitive& primitive : part.primitives) {
            if (run.stopped()) return fail(run.stopError());
            model.addPlain(primitive, placement, run);
        }
    }
    return {};
}

Result<std::vector<std::byte>> write(const Mesh& mesh, const OutputOptions& options,
                                     const nlohmann::ordered_json& extras, const RunContext& run) {
    const Placement placement = placementOf(mesh, options);
    if (auto checked = checkMesh(mesh, placement, run); !checked) return fail(checked.error());
    GlbModel model;
    const Result<void> added = options.compression == Compression::draco
                                   ? addDracoParts(mesh, placement, options, run, model)
                                   : addPlainParts(mesh, placement, run, model);
    if (!added) return fail(added.error());
    if (run.stopped()) return fail(run.stopError());
    std::vector<std::byte> bytes = model.finish(mesh.materials, toValue(extras), run);
    if (run.stopped()) return fail(run.stopError());
    if (bytes.empty()) return fail(ErrorCode::internal, "the GLB could not be written");
    if (auto fits = checkSize(bytes.size(), run); !fits) return fail(fits.error());
    return bytes;
}

}  // namespace

Result<std::vector<std::byte>> writeGlb(const Mesh& mesh, const OutputOptions& options,
                                        const nlohmann::ordered_json& extras,
                                        const RunContext& run) {
    try {
        return write(mesh, options, extras, run);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::internal, "not enough memory to write the GLB");
    } catch (const std::exception& exception) {
        return fail(ErrorCode::internal,
                    std::string("the GLB could not be written: ") + exception.what());
    }
}

}  // namespace rivage::core
