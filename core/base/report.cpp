#include "core/base/report.h"

#include <algorithm>

namespace rivage::core {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const InputReport& input) {
    Json labels = Json::array();
    for (const auto& label : input.labels)
        labels.push_back({{"name", label.name}, {"voxels", label.voxels}});
    return {{"format", input.format},       {"dims", input.dims},
            {"spacing", input.spacing},     {"voxels", input.voxels},
            {"models", input.models},       {"instances", input.instances},
            {"materials", input.materials}, {"labels", std::move(labels)}};
}

Json toJson(const SurfaceReport& surface) {
    Json interfaces = Json::array();
    for (const auto& patch : surface.interfaces) {
        interfaces.push_back(
            {{"inner", patch.inner}, {"outer", patch.outer}, {"surfels", patch.surfels}});
        if (patch.normals)
            interfaces.back()["normals"] = {{"noise", patch.normals->noise},
                                            {"sharp", patch.normals->sharp},
                                            {"radius", patch.normals->radius}};
    }
    Json json = {{"pointels", surface.pointels},
                 {"surfels", surface.surfels},
                 {"linels", surface.linels},
                 {"junction_linels", surface.junctionLinels},
                 {"junction_pointels", surface.junctionPointels},
                 {"split_pointels", surface.splitPointels}};
    if (surface.featureLinels) json["feature_linels"] = *surface.featureLinels;
    json["interfaces"] = std::move(interfaces);
    return json;
}

Json toJson(const EnergyReport& energy) {
    return {{"data", energy.data},
            {"alignment", energy.alignment},
            {"fairness", energy.fairness},
            {"total", energy.total()}};
}

Json toJson(const EmbossReport& emboss) {
    Json tiles = Json::array();
    for (const auto& tile : emboss.tiles)
        tiles.push_back(
            {{"material", tile.material}, {"tile", tile.tile}, {"surfels", tile.surfels}});
    Json json = {{"method", emboss.method},
                 {"detail", emboss.detail},
                 {"surfels", emboss.surfels},
                 {"pointels", emboss.pointels},
                 {"tiles", std::move(tiles)}};
    if (emboss.method == "normals")
        json["solver"] = {{"iterations", emboss.iterations},
                          {"relative_residual", emboss.residual}};
    json["relief"] = {{"rms", emboss.reliefRms}, {"max", emboss.reliefMax}};
    json["displacement_max"] = emboss.displacementMax;
    json["inverted_faces"] = emboss.invertedAfter;
    json["crossing_faces"] = emboss.crossingAfter;
    return json;
}

Json toJson(const OutputReport& output, bool mesh) {
    Json json = {{"media_type", output.mediaType}};
    if (mesh) {
        json["parts"] = output.parts;
        json["vertices"] = output.vertices;
        json["triangles"] = output.triangles;
    }
    if (output.bytes) json["bytes"] = *output.bytes;
    return json;
}

Json toJson(const VoxelReport::Topology& topology) {
    return {{"components", topology.components},
            {"tunnels", topology.tunnels},
            {"cavities", topology.cavities}};
}

Json toJson(const VoxelReport& voxels, const InputReport& input) {
    Json json = {{"dims", voxels.dims},
                 {"voxels", voxels.voxels},
                 {"scale", voxels.scale},
                 {"samples_per_voxel", voxels.samplesEach},
                 {"folded_samples", voxels.folded},
                 {"colors", voxels.colors},
                 {"models", voxels.models}};
    if (voxels.paletteError)
        json["palette_error"] = {{"max", voxels.paletteError->max},
                                 {"mean", voxels.paletteError->mean}};
    if (voxels.topology.empty()) return json;
    json["rescued_voxels"] = voxels.rescued;
    json["topology"] = Json::object();
    for (std::size_t i = 0; i < voxels.topology.size(); ++i)
        json["topology"][input.labels[i].name] = {{"before", toJson(voxels.topology[i].before)},
                                                  {"after", toJson(voxels.topology[i].after)}};
    return json;
}

Json byLabel(const ConversionReport& report, const std::vector<bool>& values) {
    Json object = Json::object();
    for (std::size_t i = 0; i < values.size(); ++i)
        object[report.input.labels[i].name] = static_cast<bool>(values[i]);
    return object;
}

const char* evidenceName(Evidence evidence) {
    switch (evidence) {
        case Evidence::none: return "none";
        case Evidence::checked: return "checked";
        case Evidence::proved: return "proved";
    }
    return "none";
}

Json toJson(const Guarantees& guarantees) {
    return {{"separation", evidenceName(guarantees.separation)},
            {"no_intersection", evidenceName(guarantees.noIntersection)},
            {"no_inversion", evidenceName(guarantees.noInversion)},
            {"closed", evidenceName(guarantees.closed)}};
}

}  // namespace

Guarantees guaranteesOf(const ConversionReport& report) {
    const SolveReport& solve = report.solve;
    const std::vector<bool>& closed = report.output.closed;
    const auto& emboss = report.emboss;
    const bool separated = (emboss ? emboss->displacementMax : solve.displacementMax) < 0.5;
    Guarantees guarantees;
    if (separated) guarantees.separation = Evidence::proved;
    // The pieces of one face, and of faces side by side, are nearer to each other than they move.
    if (!emboss && separated && solve.crossingAfter == 0)
        guarantees.noIntersection =
            report.surface.splitPointels == 0 ? Evidence::proved : Evidence::checked;
    if (!emboss && solve.displacementMax < 0.25)
        guarantees.noInversion = Evidence::proved;
    else if ((emboss ? emboss->invertedAfter : solve.invertedAfter) == 0)
        guarantees.noInversion = Evidence::checked;
    if (std::find(closed.begin(), closed.end(), false) == closed.end())
        guarantees.closed = Evidence::checked;
    return guarantees;
}

Json toJson(const ConversionReport& report) {
    const SolveReport& solve = report.solve;
    Json json = {
        {"input", toJson(report.input)},
        {"options", report.options},
        {"surface", toJson(report.surface)},
        {"energy", {{"before", toJson(solve.before)}, {"after", toJson(solve.after)}}},
        {"solver",
         {{"name", solve.solver},
          {"iterations", solve.iterations},
          {"relative_residual", solve.residual}}},
        {"displacement", {{"rms", solve.displacementRms}, {"max", solve.displacementMax}}},
        {"inverted_faces", {{"before", solve.invertedBefore}, {"after", solve.invertedAfter}}},
        {"crossing_faces", {{"before", solve.crossingBefore}, {"after", solve.crossingAfter}}},
        {"closed", byLabel(report, report.output.closed)},
        {"open_at_border", byLabel(report, report.output.openAtBorder)},
        {"guarantees", toJson(guaranteesOf(report))}};
    if (report.emboss) json["emboss"] = toJson(*report.emboss);
    json["output"] = toJson(report.output, !report.voxels);
    if (report.voxels) json["voxels"] = toJson(*report.voxels, report.input);
    if (report.milliseconds) {
        double total = 0;
        for (std::size_t i = 0; i < kStageCount; ++i) {
            if (static_cast<Stage>(i) == Stage::emboss && !report.emboss) continue;
            json["milliseconds"][stageName(static_cast<Stage>(i))] = (*report.milliseconds)[i];
            total += (*report.milliseconds)[i];
        }
        json["milliseconds"]["total"] = total;
    }
    json["warnings"] = report.warnings;
    return json;
}

Json toJson(const Inspection& inspection) {
    Json palette = Json::array();
    for (const auto& entry : inspection.palette)
        palette.push_back({{"source", entry.source},
                           {"color", entry.color},
                           {"label", entry.label},
                           {"class", entry.kind},
                           {"name", entry.name}});
    return {{"input", toJson(inspection.input)},
            {"surface", {{"pointels", inspection.pointels}, {"surfels", inspection.surfels}}},
            {"predicted_memory", inspection.predictedMemory},
            {"palette", std::move(palette)},
            {"warnings", inspection.warnings}};
}

}  // namespace rivage::core
