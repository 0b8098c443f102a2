#include "client/report_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "client/failure.h"
#include "client/printable.h"
#include "client/progress.h"
#include "client/reference/joined.h"

namespace rivage::client {
namespace {

using proto::Json;

constexpr std::size_t kMostItems = 12;  ///< of a list on one line
constexpr int kNameWidth = 14;

std::string number(double value) {
    char text[64];
    const bool whole = std::floor(value) == value && std::abs(value) < 1e15;
    std::snprintf(text, sizeof text, whole ? "%.0f" : "%.5g", value);
    return text;
}

/// A count with its digits in groups of three.
std::string count(double value) {
    std::string digits = number(value);
    for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return digits;
}

std::string countOf(const Json& object, const char* name, const std::string& word) {
    const double value = numberOf(object, name);
    return count(value) + " " + word + (value == 1 ? "" : "s");
}

std::string padded(std::string text, int width) {
    text.resize(std::max(text.size(), static_cast<std::size_t>(width)), ' ');
    return text;
}

std::string row(const std::string& name, const std::string& text) {
    return "  " + padded(printable(name), kNameWidth) + printable(text) + "\n";
}

const Json& member(const Json& object, const char* name) {
    static const Json kNothing = Json::object();
    const auto found = object.find(name);
    return found == object.end() ? kNothing : *found;
}

std::string dimsText(const Json& dims) {
    std::string text;
    for (const Json& size : dims)
        if (size.is_number()) text += (text.empty() ? "" : " x ") + number(size.get<double>());
    return text;
}

/// The first of the items, and how many more there are.
std::string listText(std::vector<std::string> items) {
    const std::size_t more = items.size() - std::min(items.size(), kMostItems);
    items.resize(items.size() - more);
    return joined(items, ", ") + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

std::string inputRows(const Json& input, const Json& closed) {
    std::string rows = row(
        "grid", textOf(input, "format") + ", " + dimsText(member(input, "dims")) + ", " +
                    countOf(input, "voxels", "voxel") + ", " + countOf(input, "models", "model") +
                    ", " + countOf(input, "materials", "material"));
    std::vector<std::string> labels;
    for (const Json& label : member(input, "labels")) {
        const std::string name = textOf(label, "name");
        const bool open = closed.contains(name) && closed[name] == Json(false);
        labels.push_back(name + " " + count(numberOf(label, "voxels")) + (open ? " (open)" : ""));
    }
    return labels.empty() ? rows : rows + row("labels", listText(labels));
}

std::string energyRows(const Json& energy) {
    if (energy.empty()) return {};
    const std::vector<const char*> terms{"data", "alignment", "fairness", "total"};
    std::string head;
    for (const char* term : terms) head += padded(term, 12);
    std::string rows = row("energy", head);
    for (const char* when : {"before", "after"}) {
        std::string values;
        for (const char* term : terms)
            values += padded(number(numberOf(member(energy, when), term)), 12);
        rows += row(std::string("  ") + when, values);
    }
    return rows;
}

std::string timeRow(const Json& milliseconds) {
    std::string text;
    for (const auto& [stage, value] : milliseconds.items()) {
        if (!value.is_number()) continue;
        char part[96];
        const double time = value.get<double>();
        std::snprintf(part, sizeof part, std::abs(time) < 1e15 ? "%.1f" : "%.0e", time);
        text += (text.empty() ? "" : ", ") + stage + " " + part;
    }
    return text.empty() ? text : row("time", text + " ms");
}

std::string warningRows(const Json& object) {
    std::string rows;
    for (const Json& warning : member(object, "warnings"))
        if (warning.is_string()) rows += row("warning", warning.get<std::string>());
    return rows;
}

/// What a result of voxels is.
std::string voxelText(const Json& voxels) {
    std::string text =
        ", scale " + textOf(voxels, "scale") + ", " + dimsText(member(voxels, "dims")) + ", " +
        countOf(voxels, "voxels", "voxel") + ", " + countOf(voxels, "colors", "colour") + ", " +
        countOf(voxels, "models", "model");
    if (const Json& error = member(voxels, "palette_error"); !error.empty())
        text += ", colours off by " + number(numberOf(error, "mean")) + " on average, " +
                number(numberOf(error, "max")) + " at most";
    return text;
}

std::string valueText(const Json& value) {
    return value.is_string() ? value.get<std::string>() : proto::writeJson(value);
}

}  // namespace

std::string reportTable(const Json& report) {
    const Json& surface = member(report, "surface");
    const Json& solver = member(report, "solver");
    const Json& inverted = member(report, "inverted_faces");
    const Json& output = member(report, "output");
    const Json& displacement = member(report, "displacement");
    char residual[64];
    std::snprintf(residual, sizeof residual, "%.1e", numberOf(solver, "relative_residual"));

    std::string text = inputRows(member(report, "input"), member(report, "closed"));
    text +=
        row("surface",
            countOf(surface, "surfels", "face") + ", " + countOf(surface, "pointels", "pointel") +
                ", " + count(static_cast<double>(member(surface, "interfaces").size())) +
                " interface(s), " + countOf(surface, "junction_linels", "junction edge"));
    text += energyRows(member(report, "energy"));
    text +=
        row("solver", textOf(solver, "name") + ", " + countOf(solver, "iterations", "iteration") +
                          ", relative residual " + residual);
    text += row("displacement", number(numberOf(displacement, "rms")) + " rms, " +
                                    number(numberOf(displacement, "max")) + " max, in voxels");
    text += row("inverted", count(numberOf(inverted, "before")) + " faces before, " +
                                count(numberOf(inverted, "after")) + " after repair");
    const Json& voxels = member(report, "voxels");
    std::string written = textOf(output, "media_type");
    if (voxels.empty())
        written += ", " + countOf(output, "parts", "part") + ", " +
                   count(numberOf(output, "vertices")) + " vertices, " +
                   countOf(output, "triangles", "triangle");
    else
        written += voxelText(voxels);
    if (output.contains("bytes")) written += ", " + bytesText(numberOf(output, "bytes"));
    return text + row("output", written) + timeRow(member(report, "milliseconds")) +
           warningRows(report);
}

std::string inspectionTable(const Json& inspection) {
    const Json& surface = member(inspection, "surface");
    std::string text = inputRows(member(inspection, "input"), Json::object());
    text += row("surface", countOf(surface, "surfels", "face") + ", " +
                               countOf(surface, "pointels", "pointel"));
    text += row("memory", bytesText(numberOf(inspection, "predicted_memory")) + " predicted");
    for (const Json& entry : member(inspection, "palette")) {
        const std::string name = textOf(entry, "name");
        text += row("color " + number(numberOf(entry, "source")),
                    padded(textOf(entry, "color"), 11) + padded(textOf(entry, "class"), 10) +
                        padded(textOf(entry, "label"), 12) + name);
    }
    return text + warningRows(inspection);
}

std::string optionTable(const Json& answer) {
    std::string text;
    std::string group;
    for (const Json& option : member(answer, "options")) {
        if (textOf(option, "group") != group) {
            group = textOf(option, "group");
            text += (text.empty() ? "" : "\n") + printable(group) + "\n";
        }
        std::vector<std::string> allowed;
        for (const Json& value : member(option, "values")) allowed.push_back(valueText(value));
        if (textOf(option, "type") == "flag") allowed = {"true", "false"};
        if (option.contains("minimum"))
            allowed.push_back(valueText(option["minimum"]) + ".." +
                              valueText(member(option, "maximum")));
        std::string flag = "--" + textOf(option, "name");
        std::replace(flag.begin(), flag.end(), '_', '-');
        const Json& normal = member(option, "default");
        text += "  " + padded(printable(flag), 23) + printable(listText(allowed));
        if (!normal.is_null()) text += "; default " + printable(valueText(normal));
        text += "\n" + std::string(25, ' ') + printable(textOf(option, "description")) + "\n";
    }
    return text;
}

}  // namespace rivage::client
