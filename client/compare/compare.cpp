#include "client/compare/compare.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <thread>
#include <utility>

#include "client/compare/distance.h"
#include "client/compare/glb_document.h"
#include "client/compare/measures.h"
#include "client/compare/report_difference.h"

namespace rivage::client {
namespace {

using Eigen::Vector3d;
using proto::Json;

constexpr double kSameVoxels = 0.01;     ///< nobody sees less; a Draco file moves vertices by 0.007
constexpr double kSameDiagonals = 1e-4;  ///< where nothing tells how long a voxel is
constexpr double kSameColors = 0.001;    ///< a share: borders of colours move a little
constexpr double kSameDegrees = 10;      ///< in the mean; more is a surface that is turned
constexpr double kTieDiagonals = 1e-7;   ///< the precision of float positions
constexpr double kZeroDiagonals = 1e-13;  ///< the rounding of the search

/// A file with what has been measured of it.
struct Side {
    std::string name;
    Surface surface;
    Measures whole;
};

Json row(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Outcome<Side> readSide(const std::string& name, const std::string& bytes) {
    Side side{.name = name};
    auto surface = readSurface(bytes);
    if (surface) {
        side.surface = std::move(*surface);
        side.whole = measure(side.surface, 0, side.surface.triangles.size());
        if (side.whole.flat < side.surface.triangles.size()) return side;
        surface = unsupported("none of its triangles has an area");
    }
    Failure failure = surface.error();
    failure.problem["detail"] = name + ": " + textOf(failure.problem, "detail");
    return tl::unexpected(std::move(failure));
}

Json describeSide(const Side& side) {
    const Surface& surface = side.surface;
    const Measures& whole = side.whole;
    Json json = {{"name", side.name},
                 {"format", surface.format},
                 {"bytes", surface.bytes},
                 {"parts", surface.parts.size()},
                 {"primitives", surface.primitives},
                 {"materials", surface.materials},
                 {"vertices", surface.positions.size()},
                 {"triangles", surface.triangles.size()},
                 {"flat_triangles", whole.flat},
                 {"box", {{"min", row(whole.low)}, {"max", row(whole.high)}}},
                 {"area", whole.area},
                 {"closed", whole.volume.has_value()}};
    json["volume"] = whole.volume ? Json(*whole.volume) : Json();
    return json;
}

/// Parts by name; empty if two have the same name, or one has none or nothing to measure.
std::map<std::string, std::size_t> partsByName(const Surface& surface) {
    std::map<std::string, std::size_t> parts;
    for (std::size_t i = 0; i < surface.parts.size(); ++i) {
        const SurfacePart& part = surface.parts[i];
        const bool flat = measure(surface, part.first, part.count).flat == part.count;
        if (part.name.empty() || flat || !parts.emplace(part.name, i).second) return {};
    }
    return parts;
}

/// Parts of the same name where both files have the same names, else everything at once.
std::vector<PartPair> pairUp(const Surface& a, const Surface& b) {
    const auto partsA = partsByName(a);
    const auto partsB = partsByName(b);
    std::vector<PartPair> pairs;
    for (const auto& [name, index] : partsA)
        if (const auto found = partsB.find(name); found != partsB.end())
            pairs.push_back({index, found->second});
    if (pairs.empty() || pairs.size() != partsA.size() || pairs.size() != partsB.size())
        return {PartPair{}};
    std::sort(pairs.begin(), pairs.end(),
              [](const PartPair& x, const PartPair& y) { return x.a < y.a; });
    return pairs;
}

double quantile(std::vector<double>& values, double share) {
    const std::ptrdiff_t at = std::lround(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[at];
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

/// The figures of some samples, in metres and, where its size is known, in voxels.
Json figures(std::vector<double> distances, const Farthest& farthest,
             const std::optional<double>& voxel) {
    double squares = 0;
    for (const double distance : distances) squares += distance * distance;
    const Json meters = {{"mean", mean(distances)},
                         {"rms", std::sqrt(squares / static_cast<double>(distances.size()))},
                         {"p95", quantile(distances, 0.95)},
                         {"p99", quantile(distances, 0.99)},
                         {"max", farthest.distance},
                         {"max_at_most", farthest.atMost}};
    Json voxels;
    if (voxel)
        for (const auto& [name, value] : meters.items())
            voxels[name] = value.get<double>() / *voxel;
    return {{"meters", meters}, {"voxels", voxels}, {"samples", distances.size()}};
}

const Farthest& farthestOf(const DistanceSamples& samples) {
    return std::max_element(samples.rows.begin(), samples.rows.end(),
                            [](const auto& x, const auto& y) {
                                return x.farthest.distance < y.farthest.distance;
                            })
        ->farthest;
}

Json describeWay(const DistanceSamples& samples, const std::optional<double>& voxel) {
    Farthest most = farthestOf(samples);
    for (const auto& one : samples.rows) most.atMost = std::max(most.atMost, one.farthest.atMost);
    Json json = figures(samples.distances, most, voxel);
    json["at"] = row(most.at);
    return json;
}

Json partFigures(const DistanceSamples& samples, const DistanceSamples::Row& one,
                 const std::optional<double>& voxel) {
    const auto first = samples.distances.begin() + static_cast<std::ptrdiff_t>(one.firstSample);
    return figures({first, first + static_cast<std::ptrdiff_t>(one.samples)}, one.farthest, voxel);
}

std::vector<double> together(const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<double> all = x;
    all.insert(all.end(), y.begin(), y.end());
    return all;
}

/// Everything about the two surfaces that the way from A to B and the way back tell.
struct Ways {
    std::vector<PartPair> pairs;
    DistanceSamples there;
    DistanceSamples back;
};

Ways measureWays(const Side& a, const Side& b, const CompareSettings& settings) {
    Ways ways{.pairs = pairUp(a.surface, b.surface)};
    const double diagonal =
        std::max((a.whole.high - a.whole.low).norm(), (b.whole.high - b.whole.low).norm());
    const unsigned machine = std::max(1U, std::thread::hardware_concurrency());
    const DistanceSettings how{.samples = std::max<std::size_t>(1, settings.samples),
                               .tolerance = kTieDiagonals * diagonal,
                               .zero = kZeroDiagonals * diagonal,
                               .threads = settings.threads == 0 ? machine : settings.threads};
    ways.there = measureDistance(a.surface, b.surface, ways.pairs, how);
    std::vector<PartPair> turned;
    for (const PartPair& pair : ways.pairs) turned.push_back({pair.b, pair.a});
    ways.back = measureDistance(b.surface, a.surface, turned, how);
    return ways;
}

Json colorShare(const Ways& ways) {
    const std::size_t count = ways.there.otherColor.size() + ways.back.otherColor.size();
    if (count == 0) return {};
    const auto differing =
        std::count(ways.there.otherColor.begin(), ways.there.otherColor.end(), 1) +
        std::count(ways.back.otherColor.begin(), ways.back.otherColor.end(), 1);
    return {{"different", static_cast<double>(differing) / static_cast<double>(count)}};
}

void addWays(const Side& a, const Ways& ways, const std::optional<double>& voxel, Json& json) {
    const double max = std::max(farthestOf(ways.there).distance, farthestOf(ways.back).distance);
    json["distance"] = {
        {"a_to_b", describeWay(ways.there, voxel)},
        {"b_to_a", describeWay(ways.back, voxel)},
        {"max", {{"meters", max}, {"voxels", voxel ? Json(max / *voxel) : Json()}}}};
    std::vector<double> degrees = together(ways.there.degrees, ways.back.degrees);
    json["normals"] = {{"mean_degrees", mean(degrees)}, {"p95_degrees", quantile(degrees, 0.95)}};
    json["colors"] = colorShare(ways);
    json["parts"] = Json::array();
    if (ways.pairs.front().a == DistanceSamples::kWhole) return;
    for (std::size_t i = 0; i < ways.pairs.size(); ++i)
        json["parts"].push_back({{"name", a.surface.parts[ways.pairs[i].a].name},
                                 {"a_to_b", partFigures(ways.there, ways.there.rows[i], voxel)},
                                 {"b_to_a", partFigures(ways.back, ways.back.rows[i], voxel)}});
}

std::optional<double> voxelSizeOf(const Side& a, const Side& b, const CompareSettings& settings) {
    if (settings.voxelSize) return settings.voxelSize;
    for (const Side* side : {&a, &b}) {
        const double size = numberOf(memberOf(side->surface.report, "options"), "voxel_size");
        if (size > 0 && std::isfinite(size)) return size;
    }
    return std::nullopt;
}

std::string lengthText(const Json& distance) {
    const bool voxels = distance["voxels"].is_number();
    char text[64];
    std::snprintf(text, sizeof text, voxels ? "%.3g voxel" : "%.3g m",
                  distance[voxels ? "voxels" : "meters"].get<double>());
    return text;
}

Json verdictOf(const Json& json, const Side& a, bool sameBytes) {
    if (sameBytes) return {{"kind", "same_bytes"}, {"text", "same bytes"}};
    const Json& max = json["distance"]["max"];
    const double diagonal = (a.whole.high - a.whole.low).norm();
    const bool near = max["voxels"].is_number()
                          ? max["voxels"].get<double>() <= kSameVoxels
                          : max["meters"].get<double>() <= kSameDiagonals * diagonal;
    const bool turned = json["normals"]["mean_degrees"].get<double>() > kSameDegrees;
    std::string text = near && !turned ? "same surface" : "differs";
    text += " (max distance " + lengthText(max);
    if (near && turned) text += ", but its faces point elsewhere";
    if (json["colors"].is_object() && json["colors"]["different"].get<double>() > kSameColors) {
        char share[64];
        std::snprintf(share, sizeof share, ", other colours on %.3g %%",
                      100 * json["colors"]["different"].get<double>());
        text += share;
    }
    return {{"kind", near && !turned ? "same_surface" : "different"}, {"text", text + ")"}};
}

Outcome<Json> compare(const std::string& bytesA, const std::string& bytesB,
                      const CompareSettings& settings) {
    const auto a = readSide(settings.nameA, bytesA);
    if (!a) return tl::unexpected(a.error());
    const auto b = readSide(settings.nameB, bytesB);
    if (!b) return tl::unexpected(b.error());
    const std::optional<double> voxel = voxelSizeOf(*a, *b, settings);
    if (settings.maxDistance && !voxel)
        return fail(ExitCode::usage, "The size of a voxel is not known",
                    "neither file has a report; say it with --voxel-size");
    const Json& reportA = a->surface.report;
    const Json& reportB = b->surface.report;
    Json json = {{"a", describeSide(*a)}, {"b", describeSide(*b)}};
    json["voxel_size"] = voxel ? Json(*voxel) : Json();
    addWays(*a, measureWays(*a, *b, settings), voxel, json);
    json["energy"] = energiesOf(reportA, reportB);
    json["options"] = optionsThatDiffer(reportA, reportB);
    json["notes"] = notesOn(reportA, reportB);
    if (settings.maxDistance)
        json["max_distance"] = {
            {"voxels", *settings.maxDistance},
            {"exceeded", json["distance"]["max"]["voxels"].get<double>() > *settings.maxDistance}};
    json["verdict"] = verdictOf(json, *a, bytesA == bytesB);
    return json;
}

}  // namespace

Outcome<Json> compareAssets(const std::string& bytesA, const std::string& bytesB,
                            const CompareSettings& settings) {
    try {
        return compare(bytesA, bytesB, settings);
    } catch (const std::bad_alloc&) {
        return fail(ExitCode::failed, "There is not enough memory to compare the files");
    }
}

ExitCode exitOf(const Json& comparison) {
    const bool exceeded = memberOf(memberOf(comparison, "max_distance"), "exceeded") == Json(true);
    return exceeded ? ExitCode::failed : ExitCode::ok;
}

}  // namespace rivage::client
