#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "client/compare/surface.h"

namespace rivage::client {

/// Where the elements of an accessor lie; checked to be inside the file.
struct AccessorData {
    const unsigned char* first = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;
    int componentType = 0;  ///< as glTF numbers them: 5126 is float
    int components = 0;
    bool normalized = false;

    [[nodiscard]] std::size_t bytes() const;
    /// A component as a number; normalized integers become 0..1 or -1..1.
    [[nodiscard]] float number(std::size_t element, int component) const;
    /// An element that is an index.
    [[nodiscard]] std::uint32_t index(std::size_t element) const;
};

/// The two chunks of a GLB and the checked way into them. Keeps a view of the bytes.
class GlbDocument {
public:
    /// @errors  refused if the container is malformed, or needs an extension that is not read here
    static Outcome<GlbDocument> open(std::string_view bytes, const SurfaceLimits& limits);

    [[nodiscard]] const proto::Json& json() const { return json_; }
    [[nodiscard]] std::size_t jsonBytes() const { return jsonBytes_; }

    /// The element of a list of the root object.
    /// @errors  refused if there is none
    [[nodiscard]] Outcome<const proto::Json*> element(const char* list,
                                                      const proto::Json& index) const;
    [[nodiscard]] Outcome<std::string_view> bufferView(const proto::Json& index) const;
    [[nodiscard]] Outcome<AccessorData> accessor(const proto::Json& index) const;

private:
    proto::Json json_;
    std::size_t jsonBytes_ = 0;
    std::string_view binary_;  ///< buffer 0
};

/// A member as a whole number from 0 to 2^53; `otherwise` if there is none, nothing if it is not.
[[nodiscard]] std::optional<std::uint64_t> wholeOf(const proto::Json& object, const char* name,
                                                   std::uint64_t otherwise);

/// A value as a whole number from 0 to 2^53.
[[nodiscard]] std::optional<std::uint64_t> wholeOf(const proto::Json& value);

/// A member of an object; null if there is none or `object` is none.
[[nodiscard]] const proto::Json& memberOf(const proto::Json& object, const char* name);

}  // namespace rivage::client
