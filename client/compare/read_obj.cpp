#include <charconv>
#include <cmath>
#include <cstdlib>
#include <set>
#include <string_view>
#include <utility>

#include "client/compare/surface.h"

namespace rivage::client {
namespace {

using Eigen::Vector3f;

constexpr float kWhite = 1;

/// Takes the next word off a line.
std::string_view nextWord(std::string_view& line) {
    const std::size_t from = line.find_first_not_of(" \t\r");
    if (from == std::string_view::npos) return line = {};
    const std::size_t to = std::min(line.find_first_of(" \t\r", from), line.size());
    const std::string_view word = line.substr(from, to - from);
    line.remove_prefix(to);
    return word;
}

bool readNumber(std::string_view word, float& value) {
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
}

/// sRGB from 0 to 1 as linear light.
float linear(float value) {
    return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

class ObjReader {
public:
    ObjReader(const std::string& bytes, const SurfaceLimits& limits)
        : rest_(bytes), limits_(limits) {}

    Outcome<Surface> read() {
        surface_.format = "obj";
        surface_.bytes["file"] = rest_.size();
        while (!rest_.empty()) {
            ++line_;
            if (auto done = readLine(takeLine()); !done) return tl::unexpected(done.error());
        }
        endPart();
        for (const auto& triangle : surface_.triangles)
            for (const std::uint32_t v : triangle)
                if (v >= surface_.positions.size()) return malformed("a face names no vertex");
        if (!colored_) surface_.colors.clear();
        surface_.materials = materials_.size();
        return std::move(surface_);
    }

private:
    std::string_view takeLine() {
        const std::size_t end = std::min(rest_.find('\n'), rest_.size());
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        return line;
    }

    [[nodiscard]] tl::unexpected<Failure> wrong(const std::string& what) const {
        return malformed("line " + std::to_string(line_) + ": " + what);
    }

    Outcome<void> readLine(std::string_view line) {
        const std::string_view keyword = nextWord(line);
        if (keyword == "v") return readVertex(line);
        if (keyword == "f") return readFace(line);
        if (keyword == "o") {
            endPart();
            surface_.parts.push_back(
                {.name = std::string(nextWord(line)), .first = surface_.triangles.size()});
        } else if (keyword == "g") {
            ++surface_.primitives;
        } else if (keyword == "usemtl") {
            materials_.emplace(nextWord(line));
        }
        return {};
    }

    /// Ends the part that is being read; one without a face is none.
    void endPart() {
        if (surface_.parts.empty()) return;
        SurfacePart& part = surface_.parts.back();
        part.count = surface_.triangles.size() - part.first;
        if (part.count == 0) surface_.parts.pop_back();
    }

    Outcome<void> readVertex(std::string_view line) {
        std::array<float, 6> values{0, 0, 0, kWhite, kWhite, kWhite};
        std::size_t count = 0;
        for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line))
            if (count == values.size() || !readNumber(word, values[count++]))
                return wrong("a vertex is three finite numbers, or six with a colour");
        if (count < 3 || count == 5) return wrong("a vertex is three numbers, or six");
        surface_.positions.emplace_back(values[0], values[1], values[2]);
        const bool colored = count == values.size();
        colored_ = colored_ || colored;
        surface_.colors.push_back(
            colored ? Vector3f(linear(values[3]), linear(values[4]), linear(values[5]))
                    : Vector3f::Constant(kWhite));
        return {};
    }

    /// The vertex that `3`, `3/1`, `3//2` or `-1` names; a wrong one is found at the end.
    [[nodiscard]] bool readCorner(std::string_view word, std::uint32_t& vertex) const {
        word = word.substr(0, word.find('/'));
        std::int64_t number = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (error != std::errc() || end != word.data() + word.size()) return false;
        const auto known = static_cast<std::int64_t>(surface_.positions.size());
        if (number < 0) number += known + 1;
        if (number < 1 || number > INT32_MAX) return false;
        vertex = static_cast<std::uint32_t>(number - 1);
        return true;
    }

    Outcome<void> readFace(std::string_view line) {
        if (surface_.parts.empty()) surface_.parts.push_back({});
        std::uint32_t first = 0;
        std::uint32_t last = 0;
        std::size_t corners = 0;
        for (std::string_view word = nextWord(line); !word.empty(); word = nextWord(line)) {
            std::uint32_t vertex = 0;
            if (!readCorner(word, vertex)) return wrong("a face names no vertex");
            if (corners == 0) first = vertex;
            if (corners++ >= 2) surface_.triangles.push_back({first, last, vertex});
            last = vertex;
        }
        if (corners < 3) return wrong("a face has three corners or more");
        if (surface_.triangles.size() > limits_.maxTriangles)
            return unsupported("it has more than " + std::to_string(limits_.maxTriangles) +
                               " triangles");
        return {};
    }

    std::string_view rest_;
    const SurfaceLimits& limits_;
    Surface surface_;
    std::set<std::string, std::less<>> materials_;
    std::size_t line_ = 0;
    bool colored_ = false;
};

}  // namespace

Outcome<Surface> readObj(const std::string& bytes, const SurfaceLimits& limits) {
    return ObjReader(bytes, limits).read();
}

}  // namespace rivage::client
