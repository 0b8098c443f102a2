#include "core/emboss/tile_choice.h"

#include <algorithm>

namespace rivage::core {
namespace {

/// What a rule may go by, from the weakest to the strongest.
enum class By : std::uint8_t { rest, region, materialName, entry };

bool fits(const VoxelGrid& grid, const Material& m, By by, const std::string& name) {
    switch (by) {
        case By::rest: return name == "*";
        case By::region: return grid.labels[m.label] == name;
        case By::materialName: return m.name == name;
        case By::entry: return std::to_string(m.source) == name;
    }
    return false;
}

Error unknown(const VoxelGrid& grid, const std::string& name) {
    constexpr std::size_t kMost = 8;
    std::string list;
    for (std::size_t l = 1; l < std::min(grid.labels.size(), kMost + 1); ++l)
        list += (l == 1 ? "" : ", ") + grid.labels.raw()[l];
    if (grid.labels.size() > kMost + 1) list += ", ...";
    return {ErrorCode::invalidOption,
            "emboss names \"" + name +
                "\", which is no palette entry, material or region of this grid; its regions are " +
                list,
            "/options/emboss/" + name};
}

}  // namespace

Result<TileChoice> TileChoice::make(const VoxelGrid& grid, const EmbossOptions& options,
                                    double step) {
    TileChoice choice;
    choice.rule_.resize(grid.materials.size());
    for (const EmbossRule& rule : options.rules) choice.tiles_.emplace_back(rule.tile, step);
    std::vector<bool> used(options.rules.size(), false);
    for (const By by : {By::rest, By::region, By::materialName, By::entry})
        for (std::size_t r = 0; r < options.rules.size(); ++r)
            for (std::size_t m = 1; m < grid.materials.size(); ++m) {
                if (!fits(grid, grid.materials.raw()[m], by, options.rules[r].material)) continue;
                choice.rule_.raw()[m] = static_cast<std::uint32_t>(r + 1);
                used[r] = true;
            }
    for (std::size_t r = 0; r < used.size(); ++r)
        if (!used[r]) return fail(unknown(grid, options.rules[r].material));
    return choice;
}

FaceTile TileChoice::of(const DigitalSurface& surface, SurfelId s) const {
    for (const bool outer : {false, true}) {
        const MaterialId m = outer ? surface.outerMaterial[s] : surface.innerMaterial[s];
        if (rule_[m] != 0) return {&tiles_[rule_[m] - 1], rule_[m] - 1, outer};
    }
    return {};
}

}  // namespace rivage::core
