#include "core/gltf/json_value.h"

#include <cstdint>
#include <limits>

namespace rivage::core {

std::string validUtf8(std::string_view text) {
    using nlohmann::json;
    const json quoted = std::string(text);
    return json::parse(quoted.dump(-1, ' ', false, json::error_handler_t::replace))
        .get<std::string>();
}

tinygltf::Value toValue(const nlohmann::ordered_json& json) {
    if (json.is_object()) {
        tinygltf::Value::Object object;
        for (const auto& [key, item] : json.items())
            if (!item.is_null()) object.emplace(validUtf8(key), toValue(item));
        return tinygltf::Value(std::move(object));
    }
    if (json.is_array()) {
        tinygltf::Value::Array array;
        for (const auto& item : json)
            if (!item.is_null()) array.push_back(toValue(item));
        return tinygltf::Value(std::move(array));
    }
    if (json.is_string()) return tinygltf::Value(validUtf8(json.get_ref<const std::string&>()));
    if (json.is_boolean()) return tinygltf::Value(json.get<bool>());
    if (json.is_number_integer()) {
        const auto number = json.get<std::int64_t>();
        if (number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max())
            return tinygltf::Value(static_cast<int>(number));
    }
    if (json.is_number()) return tinygltf::Value(json.get<double>());
    return {};
}

}  // namespace rivage::core
