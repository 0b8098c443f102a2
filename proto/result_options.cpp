#include <utility>

#include "proto/emboss_values.h"
#include "proto/option_builders.h"
#include "proto/option_table.h"

namespace rivage::proto {
namespace {

bool isDraco(const ConversionOptions& options) {
    return options.output.format == core::OutputFormat::glb &&
           options.output.compression == core::Compression::draco;
}

bool isMesh(const ConversionOptions& options) { return !core::isVoxels(options.output.format); }

Option scaleOption() {
    return {{"scale",
             "output",
             OptionType::ratio,
             {},
             1.0 / core::kMaxScale,
             core::kMaxScale,
             "Voxels of the result for one of the input along each axis: 3 is finer, 1/2 is "
             "coarser."},
            [](JobOptions& options, const OptionValue& value) {
                options.conversion.output.scale = std::get<core::Scale>(value);
            },
            [](const JobOptions& options) -> Json {
                const core::Scale& scale = options.conversion.output.scale;
                if (scale.down == 1) return scale.up;
                return std::to_string(scale.up) + "/" + std::to_string(scale.down);
            }};
}

Option meshOnly(Option option) {
    return onlyWith("output=glb or output=obj", std::move(option), isMesh);
}

/// A .vox knows no metres; an NRRD file says itself which way its axes point.
Option notOfVox(Option option) {
    return onlyWith("output other than vox", std::move(option), [](const ConversionOptions& o) {
        return o.output.format != core::OutputFormat::vox;
    });
}

bool isEmbossed(const ConversionOptions& options) { return !options.emboss.rules.empty(); }

Option embossOption() {
    return {{"emboss", "transfer", OptionType::emboss, embossWords(), 0, 0,
             "Relief of height tiles: one for all faces, or a map from palette entries, names of "
             "materials, regions or \"*\" to a tile or its tile, size, depth and turn."},
            [](JobOptions& options, const OptionValue& value) {
                std::vector<core::EmbossRule>& rules = options.conversion.emboss.rules;
                if (const auto* word = std::get_if<Word>(&value)) {
                    if (word->index == 0) return;
                    rules = {{"*", {.kind = static_cast<core::TileKind>(word->index)}}};
                    return;
                }
                rules = std::get<std::vector<core::EmbossRule>>(value);
            },
            [](const JobOptions& options) -> Json {
                return embossJson(options.conversion.emboss.rules);
            }};
}

void addTransfer(std::vector<Option>& table) {
    table.push_back(meshOnly(embossOption()));
    const std::string condition = "emboss other than none";
    table.push_back(
        onlyWith(condition,
                 number(
                     "emboss_detail", "transfer", {2, 8},
                     "Pieces along each edge of a voxel face: the finer, the crisper the relief "
                     "and the more faces, its square as many.",
                     [](ConversionOptions & o) -> auto& { return o.emboss.detail; }),
                 isEmbossed));
    table.push_back(onlyWith(
        condition,
        choice(
            "emboss_method", "transfer", {"normals", "displace"},
            "How relief is made: pieces take the normals of their tile in a second solution, "
            "crisp; or they are moved along the normals, fast.",
            [](ConversionOptions & o) -> auto& { return o.emboss.method; }),
        isEmbossed));
}

void addOutput(std::vector<Option>& table) {
    const auto output = [](auto member) {
        return [member](ConversionOptions & o) -> auto& { return o.output.*member; };
    };
    using core::OutputOptions;
    table.push_back(choice("output", "output", {"glb", "obj", "vox", "nrrd"},
                           "Format of the result: a mesh, or voxels of the smooth model.",
                           output(&OutputOptions::format)));
    table.push_back(onlyWith("output=vox or output=nrrd", scaleOption(),
                             [](const ConversionOptions& options) { return !isMesh(options); }));
    table.push_back(meshOnly(choice("parts", "output", {"exterior", "interfaces"},
                                    "Meshes: the faces against the background, or one mesh for "
                                    "every two regions that touch.",
                                    output(&OutputOptions::parts))));
    table.push_back(meshOnly(choice("colors", "output", {"voxel", "label", "none"},
                                    "Colours: exact per voxel face, one for each region, or none.",
                                    output(&OutputOptions::colors))));
    table.push_back(
        meshOnly(choice("shading", "output", {"smooth", "crease", "flat"},
                        "Vertex normals: smooth, smooth but for sharp edges, or one per face.",
                        output(&OutputOptions::shading))));
    table.push_back(notOfVox(number("voxel_size", "output", {1e-6, 1e6},
                                    "Side of a voxel in metres, the shortest with spacing.",
                                    output(&OutputOptions::voxelSize))));
    table.push_back(notOfVox(choice("pivot", "output", {"bottom", "center", "corner", "world"},
                                    "Where the origin lies: under the middle, in the middle, in "
                                    "the low corner, or where the scene has it.",
                                    output(&OutputOptions::pivot))));
    table.push_back(meshOnly(choice("up", "output", {"y", "z"},
                                    "The axis that points up in the result; the grid's is z.",
                                    output(&OutputOptions::up))));
}

void addCompression(std::vector<Option>& table) {
    const auto output = [](auto member) {
        return [member](ConversionOptions & o) -> auto& { return o.output.*member; };
    };
    using core::OutputOptions;
    const std::string draco = "output=glb and compression=draco";
    table.push_back(onlyWith("output=glb",
                             choice("compression", "output", {"draco", "none"},
                                    "Compression of a GLB; none leaves an NRRD file unpacked too.",
                                    output(&OutputOptions::compression)),
                             [](const ConversionOptions& options) {
                                 return options.output.format == core::OutputFormat::glb ||
                                        options.output.compression == core::Compression::none;
                             }));
    table.push_back(
        onlyWith(draco,
                 numberOr("auto", "draco_position_bits", "output", {8, 30},
                          "Bits of a Draco position; auto keeps the step below 0.01 voxel.",
                          output(&OutputOptions::dracoPositionBits)),
                 isDraco));
    table.push_back(onlyWith(draco,
                             number("draco_speed", "output", {0, 10},
                                    "Draco's speed: 0 gives the smallest file, 10 is the fastest.",
                                    output(&OutputOptions::dracoSpeed)),
                             isDraco));
}

}  // namespace

void addResultOptions(std::vector<Option>& table) {
    addTransfer(table);
    addOutput(table);
    addCompression(table);
}

}  // namespace rivage::proto
