#include "client/compare/glb_document.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <utility>

namespace rivage::client {
namespace {

using proto::Json;

constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;
constexpr double kMostWhole = 9007199254740992.0;  // 2^53: beyond, a double skips numbers

template <typename Number>
Number readAs(const unsigned char* at) {
    Number value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

std::uint32_t word(std::string_view bytes, std::size_t at) {
    return readAs<std::uint32_t>(reinterpret_cast<const unsigned char*>(bytes.data() + at));
}

/// Extensions that change nothing of what is compared here, or that are understood.
bool isKnown(const std::string& extension) {
    return extension == "KHR_draco_mesh_compression" || extension == "KHR_mesh_quantization" ||
           extension.starts_with("KHR_materials_") || extension.starts_with("KHR_lights_");
}

std::size_t componentBytes(int componentType) {
    switch (componentType) {
        case 5120:
        case 5121: return 1;
        case 5122:
        case 5123: return 2;
        case 5125:
        case 5126: return 4;
        default: return 0;
    }
}

int componentsOf(const std::string& type) {
    if (type == "SCALAR") return 1;
    if (type.size() == 4 && type.starts_with("VEC") && type[3] >= '2' && type[3] <= '4')
        return type[3] - '0';
    return 0;
}

/// The chunk that starts at `at`; moves `at` behind it.
bool takeChunk(std::string_view bytes, std::size_t& at, std::uint32_t& type,
               std::string_view& chunk) {
    if (bytes.size() - at < kChunkHeaderBytes) return false;
    const std::size_t length = word(bytes, at);
    type = word(bytes, at + 4);
    at += kChunkHeaderBytes;
    if (bytes.size() - at < length) return false;
    chunk = bytes.substr(at, length);
    at += length;
    return true;
}

}  // namespace

std::size_t AccessorData::bytes() const {
    return count * componentBytes(componentType) * static_cast<std::size_t>(components);
}

float AccessorData::number(std::size_t element, int component) const {
    const unsigned char* at = first + element * stride + component * componentBytes(componentType);
    const auto scaled = [&](auto value) {
        const auto most = static_cast<float>(std::numeric_limits<decltype(value)>::max());
        const auto plain = static_cast<float>(value);
        return normalized ? std::max(plain / most, -1.0F) : plain;
    };
    switch (componentType) {
        case 5120: return scaled(readAs<std::int8_t>(at));
        case 5121: return scaled(readAs<std::uint8_t>(at));
        case 5122: return scaled(readAs<std::int16_t>(at));
        case 5123: return scaled(readAs<std::uint16_t>(at));
        case 5125: return scaled(readAs<std::uint32_t>(at));
        default: return readAs<float>(at);
    }
}

std::uint32_t AccessorData::index(std::size_t element) const {
    const unsigned char* at = first + element * stride;
    switch (componentType) {
        case 5121: return *at;
        case 5123: return readAs<std::uint16_t>(at);
        default: return readAs<std::uint32_t>(at);
    }
}

std::optional<std::uint64_t> wholeOf(const Json& value) {
    if (!value.is_number()) return std::nullopt;
    const double number = value.get<double>();
    if (!(number >= 0) || number > kMostWhole || std::floor(number) != number) return std::nullopt;
    return static_cast<std::uint64_t>(number);
}

std::optional<std::uint64_t> wholeOf(const Json& object, const char* name,
                                     std::uint64_t otherwise) {
    const Json& value = memberOf(object, name);
    return value.is_null() ? otherwise : wholeOf(value);
}

const Json& memberOf(const Json& object, const char* name) {
    static const Json kNothing;
    const auto found = object.find(name);
    return found == object.end() ? kNothing : *found;
}

Outcome<GlbDocument> GlbDocument::open(std::string_view bytes, const SurfaceLimits& limits) {
    if (bytes.size() < kHeaderBytes) return malformed("the header of the GLB is cut");
    if (word(bytes, 4) != 2) return unsupported("it is not glTF 2.0");
    if (word(bytes, 8) != bytes.size())
        return malformed("the GLB says " + std::to_string(word(bytes, 8)) + " bytes and has " +
                         std::to_string(bytes.size()));
    std::size_t at = kHeaderBytes;
    std::uint32_t type = 0;
    std::string_view chunk;
    if (!takeChunk(bytes, at, type, chunk) || type != kJsonChunk)
        return malformed("the GLB has no JSON chunk");
    GlbDocument document;
    document.jsonBytes_ = chunk.size();
    auto json = proto::readJson(
        chunk, "/json", {.maxBytes = limits.maxJsonBytes, .maxDepth = 64, .maxMembers = 1000});
    if (!json) return malformed(json.error().message);
    document.json_ = std::move(*json);
    if (!document.json_.is_object()) return malformed("the JSON of the GLB is no object");
    while (at < bytes.size()) {
        if (!takeChunk(bytes, at, type, chunk)) return malformed("a chunk of the GLB is cut");
        if (type == kBinaryChunk && document.binary_.empty()) document.binary_ = chunk;
    }
    for (const Json& extension : memberOf(document.json_, "extensionsRequired"))
        if (!extension.is_string() || !isKnown(extension.get<std::string>()))
            return unsupported("it needs the glTF extension " + proto::writeJson(extension));
    return document;
}

Outcome<const Json*> GlbDocument::element(const char* list, const Json& index) const {
    const Json& elements = memberOf(json_, list);
    const auto number = wholeOf(index);
    if (!number || !elements.is_array() || *number >= elements.size())
        return malformed(std::string("there is no element ") + proto::writeJson(index) + " in " +
                         list);
    const Json& found = elements[*number];
    if (!found.is_object())
        return malformed(std::string("an element of ") + list + " is no object");
    return &found;
}

Outcome<std::string_view> GlbDocument::bufferView(const Json& index) const {
    const auto view = element("bufferViews", index);
    if (!view) return tl::unexpected(view.error());
    const auto number = wholeOf(**view, "buffer", 0);
    const auto offset = wholeOf(**view, "byteOffset", 0);
    const auto length = wholeOf(memberOf(**view, "byteLength"));
    if (!number || !offset || !length) return malformed("a buffer view has no length");
    const auto buffer = element("buffers", *number);
    if (!buffer) return tl::unexpected(buffer.error());
    if (*number != 0 || !memberOf(**buffer, "uri").is_null())
        return unsupported("its data is outside of the GLB");
    const auto size = wholeOf(memberOf(**buffer, "byteLength"));
    if (!size || *size > binary_.size()) return malformed("the buffer is longer than the file");
    if (*offset > *size || *length > *size - *offset)
        return malformed("a buffer view reaches beyond the buffer");
    return binary_.substr(*offset, *length);
}

Outcome<AccessorData> GlbDocument::accessor(const Json& index) const {
    const auto found = element("accessors", index);
    if (!found) return tl::unexpected(found.error());
    const Json& accessor = **found;
    if (!memberOf(accessor, "sparse").is_null()) return unsupported("it has sparse accessors");
    const auto bytes = bufferView(memberOf(accessor, "bufferView"));
    if (!bytes) return tl::unexpected(bytes.error());
    const auto view = element("bufferViews", memberOf(accessor, "bufferView"));
    const auto offset = wholeOf(accessor, "byteOffset", 0);
    const auto count = wholeOf(memberOf(accessor, "count"));
    const auto type = wholeOf(memberOf(accessor, "componentType"));
    AccessorData data;
    data.componentType = type && *type < 6000 ? static_cast<int>(*type) : 0;
    data.components = componentsOf(textOf(accessor, "type"));
    const std::size_t element = componentBytes(data.componentType) * data.components;
    const auto stride = wholeOf(**view, "byteStride", element);
    if (element == 0 || !offset || !count || *count == 0 || !stride || *stride < element)
        return malformed("an accessor makes no sense");
    // Division, as a product of numbers from a file may overflow.
    if (*offset > bytes->size() || bytes->size() - *offset < element ||
        (*count > 1 && (bytes->size() - *offset - element) / *stride < *count - 1))
        return malformed("an accessor reaches beyond its buffer view");
    data.first = reinterpret_cast<const unsigned char*>(bytes->data()) + *offset;
    data.count = *count;
    data.stride = *stride;
    data.normalized = memberOf(accessor, "normalized") == Json(true);
    return data;
}

}  // namespace rivage::client
