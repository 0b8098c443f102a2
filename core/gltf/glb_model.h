#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/base/run_context.h"
#include "core/gltf/draco_primitive.h"
#include "core/gltf/placement.h"
#include "core/gltf/private_tinygltf.h"
#include "core/mesh/mesh.h"

namespace rivage::core {

/// A glTF model under construction with its single buffer. May throw what its containers throw;
/// holds nothing meaningful once `run` asked to stop.
class GlbModel {
public:
    /// Makes room for the bytes of all primitives, as growing copies them.
    void reserve(std::size_t bytes) { buffer_.reserve(bytes); }
    /// Starts a node and mesh for the part; the primitives that follow belong to it.
    void beginPart(const MeshPart& part);
    /// Adds a primitive whose data is a Draco stream.
    void addDraco(const DracoPrimitive& encoded, std::uint32_t material);
    /// Adds a primitive with plain buffers: floats, 16-bit colours, 16 or 32-bit indices.
    void addPlain(const MeshPrimitive& primitive, const Placement& placement,
                  const RunContext& run);
    /// Adds materials and asset data and serializes the whole.
    /// @return empty if the library refuses or `run` asked to stop
    [[nodiscard]] std::vector<std::byte> finish(const std::vector<MeshMaterial>& materials,
                                                const tinygltf::Value& report,
                                                const RunContext& run);
    [[nodiscard]] std::size_t bufferBytes() const { return buffer_.size(); }

private:
    struct AccessorKind {
        int componentType;
        int type;
        bool normalized = false;
    };

    int addView(std::span<const std::byte> bytes, int target);
    int addAccessor(int view, const AccessorKind& kind, std::size_t count);
    void setBounds(int accessor, const std::array<float, 3>& low, const std::array<float, 3>& high);
    void addPlainIndices(const MeshPrimitive& primitive, const RunContext& run,
                         tinygltf::Primitive& out);

    tinygltf::Model model_;
    std::vector<unsigned char> buffer_;
    std::set<std::string> extensions_;
    bool usesDraco_ = false;
};

}  // namespace rivage::core
