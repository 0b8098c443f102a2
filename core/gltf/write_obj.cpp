#include "core/gltf/write_obj.h"

#include <array>
#include <charconv>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

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
        bytes_.insert(bytes_.end(), first, first + text.size());
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
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] bool full() const { return bytes_.size() > limit_; }
    [[nodiscard]] std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::uint64_t limit_;
    std::vector<std::byte> bytes_;
};

// Both stop at the limit, so a text is never much longer than that.
void addVertices(const MeshPrimitive& primitive, const Placement& placement, ObjText& text) {
    for (std::size_t v = 0; v < primitive.positions.size() && !text.full(); ++v) {
        text.addRow("v", placement.position(primitive.positions[v]));
        if (!primitive.colors.empty())
            for (std::size_t i = 0; i < 3; ++i)
                text.addNumber(" ",
                               static_cast<float>(srgbFromLinear(primitive.colors[v][i])) / 255.0F);
        text.add("\n");
    }
    for (const Vec3f& normal : primitive.normals) {
        if (text.full()) return;
        text.addRow("vn", placement.direction(normal.cast<double>()).cast<float>());
        text.add("\n");
    }
}

void addFaces(const MeshPrimitive& primitive, std::uint64_t firstVertex, std::uint64_t firstNormal,
              ObjText& text) {
    for (const Quad& quad : primitive.quads) {
        if (text.full()) return;
        text.add("f");
        for (const std::uint32_t v : quad) {
            text.addNumber(" ", firstVertex + v);
            if (!primitive.normals.empty()) text.addNumber("//", firstNormal + v);
        }
        text.add("\n");
    }
}

Result<std::vector<std::byte>> write(const Mesh& mesh, const OutputOptions& options,
                                     const RunContext& run) {
    const Placement placement = placementOf(mesh, options);
    if (auto checked = checkMesh(mesh, placement); !checked) return fail(checked.error());
    ObjText text(run.limits.maxOutputBytes);
    text.add("# Rivage " RIVAGE_VERSION ", metres, ");
    text.add(options.up == UpAxis::y ? "y up\n" : "z up\n");
    std::uint64_t nextVertex = 1;
    std::uint64_t nextNormal = 1;
    for (const MeshPart& part : mesh.parts) {
        text.add("o " + objName(part.name) + "\n");
        for (const MeshPrimitive& primitive : part.primitives) {
            if (run.stopped()) return fail(run.stopError());
            text.add("g " + objName(part.name) + " " +
                     objName(mesh.materials[primitive.material].name) + "\n");
            addVertices(primitive, placement, text);
            addFaces(primitive, nextVertex, nextNormal, text);
            nextVertex += primitive.positions.size();
            nextNormal += primitive.normals.size();
            const auto fits = checkOutputBytes(text.size(), run.limits.maxOutputBytes);
            if (!fits) return fail(fits.error());
        }
    }
    return text.take();
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
