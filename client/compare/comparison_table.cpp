#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "client/compare/compare.h"
#include "client/compare/glb_document.h"
#include "client/printable.h"

namespace rivage::client {
namespace {

using proto::Json;

constexpr std::size_t kNameWidth = 28;
constexpr std::size_t kColumnWidth = 20;

/// What a file says, on one line that is not too long.
std::string shown(const std::string& text) {
    constexpr std::size_t kShown = 200;
    return printable(cutTo(text, kShown)) + (text.size() > kShown ? "..." : "");
}

std::string padded(std::string text, std::size_t width) {
    // One blank at least, should the text fill its column.
    text.resize(std::max(text.size() + 1, width), ' ');
    return text;
}

std::string number(const Json& value, const char* format = "%.4g") {
    if (!value.is_number()) return "-";
    char text[64];
    std::snprintf(text, sizeof text, format, value.get<double>());
    return text;
}

/// A count with its digits in groups of three.
std::string count(const Json& value) {
    std::string digits = number(value, "%.0f");
    for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, ",");
    return digits;
}

std::string line(const std::string& name, const std::string& a, const std::string& b,
                 const std::string& more = {}) {
    std::string text =
        "  " + padded(name, kNameWidth) + padded(a, kColumnWidth) + padded(b, kColumnWidth) + more;
    text.erase(text.find_last_not_of(' ') + 1);
    return text + "\n";
}

/// "+12.5 %" or "x 16.3", from A to B; empty where that says nothing.
std::string change(const Json& a, const Json& b) {
    if (!a.is_number() || !b.is_number()) return {};
    const double from = a.get<double>();
    const double ratio = b.get<double>() / from;
    if (!(std::abs(from) > 0) || !(std::abs(ratio - 1) >= 0.00005)) return {};
    const bool large = std::abs(ratio) >= 10;
    char text[64];
    std::snprintf(text, sizeof text, large ? "x %.3g" : "%+.2f %%",
                  large ? ratio : 100 * (ratio - 1));
    return text;
}

std::string lineOf(const std::string& name, const Json& a, const Json& b) {
    return line(name, number(a), number(b), change(a, b));
}

std::string sizeText(const Json& box) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i)
        text += (i == 0 ? "" : " x ") +
                number(Json(box["max"][i].get<double>() - box["min"][i].get<double>()), "%.3g");
    return text;
}

std::string placeText(const Json& place) {
    return number(place[0]) + " " + number(place[1]) + " " + number(place[2]);
}

std::string fileLines(const Json& a, const Json& b) {
    std::string text = line("", shown(textOf(a, "name")), shown(textOf(b, "name")));
    text += line("format", textOf(a, "format"), textOf(b, "format"));
    const Json& bytesA = memberOf(a, "bytes");
    const Json& bytesB = memberOf(b, "bytes");
    const auto bytes = [&](const std::string& name) {
        const Json& x = memberOf(bytesA, name.c_str());
        const Json& y = memberOf(bytesB, name.c_str());
        return line(name == "file" ? "bytes" : "  " + shown(name), count(x), count(y),
                    change(x, y));
    };
    text += bytes("file");
    for (const auto& [name, value] : bytesA.items())
        if (name != "file") text += bytes(name);
    for (const auto& [name, value] : bytesB.items())
        if (name != "file" && !bytesA.contains(name)) text += bytes(name);
    for (const char* name : {"parts", "primitives", "materials", "vertices", "triangles"})
        text += line(name, count(a[name]), count(b[name]), change(a[name], b[name]));
    text += line("box (m)", sizeText(a["box"]), sizeText(b["box"]));
    text += lineOf("area (m2)", a["area"], b["area"]);
    const auto volume = [](const Json& side) {
        return side["volume"].is_number() ? number(side["volume"]) : std::string("not closed");
    };
    return text + line("volume (m3)", volume(a), volume(b), change(a["volume"], b["volume"]));
}

std::string energyLines(const Json& energy) {
    std::string text;
    for (const char* when : {"before", "after"})
        for (const char* term : {"data", "alignment", "fairness", "total"}) {
            const Json& a = memberOf(memberOf(memberOf(energy, "a"), when), term);
            const Json& b = memberOf(memberOf(memberOf(energy, "b"), when), term);
            if (a.is_number() || b.is_number())
                text += lineOf(std::string("energy ") + when + ", " + term, a, b);
        }
    return text;
}

std::string optionLines(const Json& options) {
    const auto value = [](const Json& one) {
        if (one.is_null()) return std::string("-");
        return shown(one.is_string() ? one.get<std::string>() : proto::writeJson(one));
    };
    std::string text;
    for (const Json& option : options)
        text +=
            line("option " + shown(textOf(option, "name")), value(option["a"]), value(option["b"]));
    return text;
}

std::string distanceLines(const Json& json) {
    const Json& there = json["distance"]["a_to_b"];
    const Json& back = json["distance"]["b_to_a"];
    const bool inVoxels = there["voxels"].is_object();
    const char* unit = inVoxels ? "voxels" : "meters";
    std::string text =
        line(inVoxels ? "distance (voxels)" : "distance (m)", "from A to B", "from B to A");
    for (const char* name : {"mean", "rms", "p95", "p99", "max"})
        text += line(std::string("  ") + name, number(there[unit][name]), number(back[unit][name]));
    if (inVoxels)
        text += line("  max (m)", number(there["meters"]["max"]), number(back["meters"]["max"]));
    text += line("  at (m)", placeText(there["at"]), placeText(back["at"]));
    for (const Json& part : json["parts"])
        if (json["parts"].size() > 1)
            text += line("  max of " + shown(textOf(part, "name")),
                         number(part["a_to_b"][unit]["max"]), number(part["b_to_a"][unit]["max"]));
    return text;
}

}  // namespace

std::string comparisonTable(const Json& json) {
    std::string text = fileLines(json["a"], json["b"]) + energyLines(json["energy"]) +
                       optionLines(json["options"]) + distanceLines(json);
    text += "  " + padded("normals", kNameWidth) + "differ by " +
            number(json["normals"]["mean_degrees"], "%.3g") + " degrees in the mean, " +
            number(json["normals"]["p95_degrees"], "%.3g") + " at p95\n";
    if (json["colors"].is_object())
        text += "  " + padded("colours", kNameWidth) + "differ on " +
                number(Json(100 * json["colors"]["different"].get<double>()), "%.3g") +
                " % of the surface\n";
    for (const Json& note : json["notes"])
        text += "  " + padded("note", kNameWidth) + shown(note.get<std::string>()) + "\n";
    if (exitOf(json) != ExitCode::ok)
        text += "  " + padded("limit", kNameWidth) +
                "exceeded: " + number(json["max_distance"]["voxels"]) + " voxels\n";
    return text + textOf(json["verdict"], "text") + "\n";
}

}  // namespace rivage::client
