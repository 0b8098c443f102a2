#include "core/grid/label_assignment.h"

#include <algorithm>
#include <map>
#include <set>

namespace rivage::core {
namespace {

constexpr const char* kClassNames[] = {"opaque", "metal", "glass", "emissive", "cloud"};
constexpr const char* kField = "/options/labels";

/// What makes a label: materials with equal keys share one, and keys order the labels.
struct LabelKey {
    std::uint64_t order = 0;
    std::string name;
};
constexpr std::uint64_t kNoLabel = ~std::uint64_t{0};

tl::unexpected<Error> badMap(std::string message) {
    return fail(ErrorCode::invalidOption, std::move(message), kField);
}

/// Rule number by value, and the number of the rule that takes the rest (`kNoLabel`: none).
struct LabelMap {
    std::map<std::uint32_t, std::uint64_t> byValue;
    std::uint64_t rest = kNoLabel;
};

Result<LabelMap> checkedMap(const std::vector<LabelRule>& rules) {
    if (rules.empty()) return badMap("the label map has no label");
    LabelMap map;
    std::set<std::string> names;
    for (std::size_t r = 0; r < rules.size(); ++r) {
        const LabelRule& rule = rules[r];
        if (rule.name.empty()) return badMap("a label of the label map has no name");
        if (!names.insert(rule.name).second)
            return badMap("the label '" + rule.name + "' is defined twice");
        if (rule.rest && map.rest != kNoLabel)
            return badMap("two labels take the rest: '" + rules[map.rest].name + "' and '" +
                          rule.name + "'");
        if (rule.rest) map.rest = r;
        for (const std::uint32_t value : rule.values) {
            if (value == 0)
                return badMap("the label '" + rule.name + "' takes the value 0, which is empty");
            const auto [entry, fresh] = map.byValue.emplace(value, r);
            if (!fresh)
                return badMap("the value " + std::to_string(value) + " is taken twice, by '" +
                              rules[entry->second].name + "' and '" + rule.name + "'");
        }
    }
    return map;
}

LabelKey keyByClass(MaterialClass kind) {
    return {static_cast<std::uint64_t>(kind), kClassNames[static_cast<std::size_t>(kind)]};
}

/// Volumes name their values, if they do; palettes name colours, which are many.
LabelKey keyBySource(const Material& material, GridFormat format) {
    const bool named = format != GridFormat::vox && !material.name.empty();
    return {material.source, named ? material.name : std::to_string(material.source)};
}

LabelKey keyByMap(const LabelMap& map, const std::vector<LabelRule>& rules,
                  const Material& material) {
    const auto found = map.byValue.find(material.source);
    const std::uint64_t rule = found == map.byValue.end() ? map.rest : found->second;
    return rule == kNoLabel ? LabelKey{kNoLabel, {}} : LabelKey{rule, rules[rule].name};
}

/// Metal and light do not separate solids; glass and clouds do.
MaterialClass automaticClass(MaterialClass kind) {
    return kind == MaterialClass::glass || kind == MaterialClass::cloud ? kind
                                                                        : MaterialClass::opaque;
}

LabelKey keyOf(const Material& material, GridFormat format, const InputOptions& options,
               const LabelMap& map) {
    switch (options.labels) {
        case LabelMode::automatic:
            return format == GridFormat::vox ? keyByClass(automaticClass(material.kind))
                                             : keyBySource(material, format);
        case LabelMode::solid: return {0, "solid"};
        case LabelMode::material: return keyByClass(material.kind);
        case LabelMode::palette: return keyBySource(material, format);
        case LabelMode::map: break;
    }
    return keyByMap(map, options.labelMap, material);
}

}  // namespace

Result<IdVector<Label, std::string>> assignLabels(IdVector<MaterialId, Material>& materials,
                                                  const std::vector<bool>& used, GridFormat format,
                                                  const InputOptions& options,
                                                  const Limits& limits) {
    LabelMap map;
    if (options.labels == LabelMode::map) {
        Result<LabelMap> checked = checkedMap(options.labelMap);
        if (!checked) return fail(std::move(checked.error()));
        map = *std::move(checked);
    }
    std::map<std::uint64_t, std::string> names;  // by order of the key
    std::vector<std::uint64_t> keys(materials.size(), kNoLabel);
    for (std::size_t i = 1; i < materials.size(); ++i) {
        if (!used[i]) continue;
        LabelKey key = keyOf(materials.raw()[i], format, options, map);
        keys[i] = key.order;
        if (key.order != kNoLabel) names.emplace(key.order, std::move(key.name));
    }
    const std::uint64_t limit = std::min<std::uint64_t>(limits.maxLabels, 0xffff);
    if (names.size() > limit)
        return fail(Error{ErrorCode::tooManyLabels,
                          "the grid has " + std::to_string(names.size()) + " labels, at most " +
                              std::to_string(limit) + " are allowed",
                          kField, limit, names.size(), "--max-labels"});

    IdVector<Label, std::string> labels(1);
    std::map<std::uint64_t, Label> labelOf{{kNoLabel, Label{0}}};
    std::set<std::string> taken;
    for (auto& [order, name] : names) {
        while (!taken.insert(name).second) name += " " + std::to_string(order);
        labelOf[order] = labels.push_back(name);
    }
    for (std::size_t i = 1; i < materials.size(); ++i)
        materials.raw()[i].label = labelOf.at(keys[i]);
    return labels;
}

}  // namespace rivage::core
