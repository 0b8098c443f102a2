#include "proto/emboss_values.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "proto/option_table.h"

namespace rivage::proto {
namespace {

using core::ErrorCode;
using core::fail;
using core::Result;
using core::TileKind;
using core::TileOptions;

constexpr std::size_t kMaxName = 64;      // bytes
constexpr std::size_t kMaxRules = 256;    // each has a tile of its own in memory
constexpr std::size_t kMaxTileSide = 64;  // heights
constexpr double kMinSize = 0.5;          // voxels
constexpr double kMaxSize = 256;
constexpr double kMaxDepth = 1;

/// What is wrong, and where.
struct Place {
    std::string option;
    std::string material;

    [[nodiscard]] tl::unexpected<core::Error> refuse(const std::string& what) const {
        return fail(ErrorCode::invalidOption, option + " of " + inQuotes(material) + ": " + what,
                    "/options/" + option + "/" + material);
    }
};

std::string tileList() {
    std::string list;
    for (std::size_t i = 1; i < embossWords().size(); ++i)
        list += (i == 1 ? "" : ", ") + embossWords()[i];
    return list;
}

Result<TileKind> readKind(const Place& place, const Json& value) {
    const auto& words = embossWords();
    if (value.is_string()) {
        const auto found = std::find(words.begin() + 1, words.end(), value.get<std::string>());
        if (found != words.end()) return static_cast<TileKind>(found - words.begin());
    }
    std::string message = "a tile is " + tileList() + ", or an object with heights of its own";
    if (value.is_string()) {
        const std::string near =
            nearestName(value.get_ref<const std::string&>(), {words.begin() + 1, words.end()});
        if (!near.empty()) message += "; did you mean " + near + "?";
    }
    return place.refuse(message);
}

Result<double> readLength(const Place& place, const std::string& key, const Json& value, double low,
                          double high) {
    const bool fits =
        value.is_number() && value.get<double>() >= low && value.get<double>() <= high;
    if (fits) return value.get<double>();
    return place.refuse(key + " must be a number of voxels from " + writeJson(Json(low)) + " to " +
                        writeJson(Json(high)));
}

Result<std::vector<double>> readRow(const Place& place, const Json& row) {
    if (!row.is_array() || row.empty() || row.size() > kMaxTileSide)
        return place.refuse("height must be 1 to " + std::to_string(kMaxTileSide) +
                            " rows of 1 to " + std::to_string(kMaxTileSide) + " numbers");
    std::vector<double> heights;
    for (const Json& value : row) {
        if (!value.is_number() || !(value.get<double>() >= 0 && value.get<double>() <= 1))
            return place.refuse("a height must be a number from 0, lowest, to 1");
        heights.push_back(value.get<double>());
    }
    return heights;
}

Result<void> readHeights(const Place& place, const Json& rows, TileOptions& tile) {
    if (!rows.is_array() || rows.empty() || rows.size() > kMaxTileSide)
        return place.refuse("height must be 1 to " + std::to_string(kMaxTileSide) +
                            " rows of 1 to " + std::to_string(kMaxTileSide) + " numbers");
    for (const Json& given : rows) {
        auto row = readRow(place, given);
        if (!row) return fail(row.error());
        if (!tile.heights.empty() && row->size() != tile.heights.front().size())
            return place.refuse("the rows of height must be equally long");
        tile.heights.push_back(*std::move(row));
    }
    return {};
}

Result<void> readMember(const Place& place, const std::string& key, const Json& value,
                        TileOptions& tile) {
    if (key == "tile") {
        const auto kind = readKind(place, value);
        if (!kind) return fail(kind.error());
        tile.kind = *kind;
        return {};
    }
    if (key == "height") return readHeights(place, value, tile);
    if (key == "turn") {
        const bool fits = value.is_number_integer() && value.get<double>() >= 0 &&
                          value.get<double>() <= 270 && value.get<int>() % 90 == 0;
        if (!fits) return place.refuse("turn must be 0, 90, 180 or 270 degrees");
        tile.turn = value.get<int>();
        return {};
    }
    if (key != "size" && key != "depth")
        return place.refuse("there is no member " + inQuotes(key) +
                            "; there are tile or height, size, depth and turn");
    const bool isSize = key == "size";
    const auto length =
        readLength(place, key, value, isSize ? kMinSize : 0, isSize ? kMaxSize : kMaxDepth);
    if (!length) return fail(length.error());
    (isSize ? tile.size : tile.depth) = *length;
    return {};
}

Result<TileOptions> readTile(const Place& place, const Json& value) {
    TileOptions tile;
    if (!value.is_object()) {
        const auto kind = readKind(place, value);
        if (!kind) return fail(kind.error());
        tile.kind = *kind;
        return tile;
    }
    if (value.contains("tile") == value.contains("height"))
        return place.refuse("give either tile, the name of one, or height, rows of numbers");
    for (const auto& [key, member] : value.items())
        if (auto read = readMember(place, key, member, tile); !read) return fail(read.error());
    return tile;
}

Json tileJson(const TileOptions& tile) {
    const std::string& word = embossWords()[static_cast<std::size_t>(tile.kind)];
    const bool own = tile.kind == TileKind::own;
    if (!own && !tile.size && !tile.depth && tile.turn == 0) return word;
    Json json = own ? Json{{"height", tile.heights}} : Json{{"tile", word}};
    if (tile.size) json["size"] = *tile.size;
    if (tile.depth) json["depth"] = *tile.depth;
    if (tile.turn != 0) json["turn"] = tile.turn;
    return json;
}

}  // namespace

const std::vector<std::string>& embossWords() {
    static const std::vector<std::string> kWords{"none",     "brick",  "planks", "shingles",
                                                 "pantiles", "cobble", "panels"};
    return kWords;
}

Result<std::vector<core::EmbossRule>> readEmboss(const std::string& name, const Json& map) {
    const auto whole = [&](const std::string& what) {
        return fail(ErrorCode::invalidOption, name + " " + what, "/options/" + name);
    };
    if (map.empty()) return whole("must name a material, not be an empty map");
    if (map.size() > kMaxRules)
        return whole("must name at most " + std::to_string(kMaxRules) + " materials");
    std::vector<core::EmbossRule> rules;
    for (const auto& [material, value] : map.items()) {
        if (material.empty() || material.size() > kMaxName)
            return whole("must not name a material by " + std::to_string(material.size()) +
                         " bytes; 1 to " + std::to_string(kMaxName) + " are allowed");
        auto tile = readTile({name, material}, value);
        if (!tile) return fail(tile.error());
        rules.push_back({material, *std::move(tile)});
    }
    return rules;
}

Json embossJson(const std::vector<core::EmbossRule>& rules) {
    if (rules.empty()) return embossWords().front();
    if (rules.size() == 1 && rules.front().material == "*") {
        Json only = tileJson(rules.front().tile);
        if (only.is_string()) return only;
    }
    Json map = Json::object();
    for (const core::EmbossRule& rule : rules) map[rule.material] = tileJson(rule.tile);
    return map;
}

}  // namespace rivage::proto
