#include "core/gltf/write_obj.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/parallel.h"
#include "core/gltf/mesh_checks.h"
#include "core/gltf/placement.h"
#include "core/mesh/colors.h"

namespace rivage::core {
namespace {

// Names end at white space in OBJ, and a line break would start a statement.
std::string objName(std::string_view text) {
    std::string name;
    for (const char c : text) {
        const bool plain = static_cast<unsigned char>(c) > ' ' && c != '\x7f';
        if (plain || (!name.empty() && name.back() != '_')) name += plain ? c : '_';
    }
    return name.empty() ? "part" : name;
}

class ObjText {
public:
    explicit ObjText(std::uint64_t limit) : limit_(limit) {}

    void add(std::string_view text) {
        const auto* first = reinterpret_cast<const std::byte*>(text.data());
        if (blocks_.empty() || blocks_.back().size() >= kBlock)
            blocks_.emplace_back().reserve(kRoom);
        blocks_.back().insert(blocks_.back().end(), first, first + text.size());
        size_ += text.size();
    }
    template <typename Number>
    void addNumber(std::string_view before, Number value) {
        add(before);
        std::array<char, 32> digits{};
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
        add({digits.data(), end});
    }
    void addRow(std::string_view keyword, const Vec3f& row) {
        add(keyword);
        // Adding zero turns -0 into 0.
        for (int i = 0; i < 3; ++i) addNumber(" ", row[i] + 0.0F);
    }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool full() const { return size_ > limit_; }
    /// The whole text; some is missing once `run` asked to stop.
    [[nodiscard]] std::vector<std::byte> take(const RunContext& run) {
        std::vector<std::byte> bytes;
        bytes.reserve(size_);
        for (const auto& block : blocks_)
            if (!run.stopped()) bytes.insert(bytes.end(), block.begin(), block.end());
        return bytes;
    }

private:
    static constexpr std::size_t kBlock = 1 << 20;
    static constexpr std::size_t kRoom = kBlock + 4096;

    std::uint64_t limit_;
    std::size_t size_ = 0;
    std::vector<std::vector<std::byte>> blocks_;  // one long text would be copied as it grows
};

// Both stop at the limit, so a text is never much longer than that.
void addVertices(const MeshPrimitive& primitive, const Placement& placement, const RunContext& run,
                 ObjText& text) {
    serialFor(primitive.positions.size(), run, [&](std::size_t v) {
        if (text.full()) return;
        text.addRow("v", placement.position(primitive.positions[v]));
        if (!primitive.colors.empty())
            for (std::size_t i = 0; i < 3; ++i)
                text.addNumber(" ",
                               static_cast<float>(srgbFromLinear(primitive.colors[v][i])) / 255.0F);
        text.add("\n");
    });
    serialFor(primitive.normals.size(), run, [&](std::size_t v) {
        if (text.full()) return;
        text.addRow("vn", placement.direction(primitive.normals[v].cast<double>()).cast<float>());
        text.add("\n");
    });
}

/// Numbers of the first vertex and the first normal of a primitive in the file.
struct ObjStart {
    std::uint64_t vertex = 1;
    std::uint64_t normal = 1;
};

void addFaces(const MeshPrimitive& primitive, const ObjStart& start, const RunContext& run,
              ObjText& text) {
    serialFor(primitive.quads.size(), run, [&](std::size_t q) {
        if (text.full()) return;
        text.add("f");
        for (const std::uint32_t v : primitive.quads[q]) {
            text.addNumber(" ", start.vertex + v);
            if (!primitive.normals.empty()) text.addNumber("//", start.normal + v);
        }
        text.add("\n");
    });
}

Result<std::vector<std::byte>> write(const Mesh& mesh, const OutputOptions& options,
                                     const RunContext& run) {
    const Placement placement = placementOf(mesh, options);
    if (auto checked = checkMesh(mesh, placement, run); !checked) return fail(checked.error());
    ObjText text(run.limits.maxOutputBytes);
    text.add("# Rivage " RIVAGE_VERSION ", metres, ");
    text.add(options.up == UpAxis::y ? "y up\n" : "z up\n");
    ObjStart next;
    for (const MeshPart& part : mesh.parts) {
        text.add("o " + objName(part.name) + "\n");
        for (const MeshPrimitive& primitive : part.primitives) {
            text.add("g " + objName(part.name) + " " +
                     objName(mesh.materials[primitive.material].name) + "\n");
            addVertices(primitive, placement, run, text);
            addFaces(primitive, next, run, text);
            if (run.stopped()) return fail(run.stopError());
            next.vertex += primitive.positions.size();
            next.normal += primitive.normals.size();
            const auto fits = checkOutputBytes(text.size(), run.limits.maxOutputBytes);
            if (!fits) return fail(fits.error());
        }
    }
    std::vector<std::byte> bytes = text.take(run);
    if (run.stopped()) return fail(run.stopError());
    return bytes;
}

}  // namespace

Result<std::vector<std::byte>> writeObj(const Mesh& mesh, const OutputOptions& options,
                                        const RunContext& run) {
    try {
        return write(mesh, options, run);
    } catch (const std::bad_alloc&) {
        return fail(ErrorCode::internal, "not enough memory to write the OBJ file");
    } catch (const std::exception& exception) {
        return fail(ErrorCode::internal,
                    std::string("the OBJ file could not be written: ") + exception.what());
    }
}

}  // namespace rivage::core
