#include "core/formats/nrrd_header.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "core/formats/clean_text.h"
#include "core/formats/header_text.h"

namespace rivage::core {
namespace {

using Fields = std::map<std::string, std::string, std::less<>>;

constexpr std::string_view kField = "/grid/header/";

tl::unexpected<Error> malformed(std::string_view field, const std::string& message) {
    return fail(ErrorCode::malformedInput, "the NRRD header: " + message,
                std::string(kField).append(field));
}

tl::unexpected<Error> unsupported(std::string_view field, const std::string& message) {
    return fail(ErrorCode::unsupportedFormat, message, std::string(kField).append(field));
}

std::string lowerCase(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> list;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const std::size_t end = std::min(text.find_first_of(" \t"), text.size());
        list.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return list;
}

/// The lines of a header: fields by their names, and the keys of segments.
struct Lines {
    Fields fields;
    Fields keys;
    std::size_t bytes = 0;
};

/// One line: a comment, `field: value` or `key:=value`. @return false if it is none of them
bool readLine(std::string_view line, Lines& lines) {
    if (line.starts_with('#')) return true;
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0) return false;
    if (line.substr(colon).starts_with(":=")) {
        if (line.starts_with("Segment"))
            lines.keys.insert_or_assign(std::string(line.substr(0, colon)), line.substr(colon + 2));
        return true;
    }
    std::string name = lowerCase(trimmed(line.substr(0, colon)));
    std::erase(name, ' ');  // "space directions" and older spellings
    lines.fields.insert_or_assign(std::move(name), trimmed(line.substr(colon + 1)));
    return true;
}

Result<Lines> readLines(std::string_view text) {
    Lines lines;
    for (std::size_t at = text.find('\n') + 1;;) {
        const std::size_t end = text.find('\n', at);
        if (end == std::string_view::npos)
            return malformed("",
                             "no empty line ends it, and no values follow; a detached header "
                             "(.nhdr) cannot be read without its data file");
        std::string_view line = text.substr(at, end - at);
        if (line.ends_with('\r')) line.remove_suffix(1);
        at = end + 1;
        if (line.empty()) {
            lines.bytes = at;
            return lines;
        }
        if (!readLine(line, lines))
            return malformed("", "the line '" + cleanText(line) + "' is no field");
    }
}

std::optional<ValueType> typeNamed(std::string_view name) {
    struct Names {
        std::string_view names;
        ValueType type;
    };
    static constexpr Names kTypes[] = {
        {"|int8|int8_t|signed char|", {.bytes = 1, .isSigned = true}},
        {"|uint8|uint8_t|uchar|unsigned char|", {.bytes = 1}},
        {"|int16|int16_t|short|short int|signed short|signed short int|",
         {.bytes = 2, .isSigned = true}},
        {"|uint16|uint16_t|ushort|unsigned short|unsigned short int|", {.bytes = 2}},
        {"|int32|int32_t|int|signed int|", {.bytes = 4, .isSigned = true}},
        {"|uint32|uint32_t|uint|unsigned int|", {.bytes = 4}},
        {"|int64|int64_t|longlong|long long|long long int|signed long long|signed long long int|",
         {.bytes = 8, .isSigned = true}},
        {"|uint64|uint64_t|ulonglong|unsigned long long|unsigned long long int|", {.bytes = 8}},
        {"|float|", {.bytes = 4, .isFloat = true}},
        {"|double|", {.bytes = 8, .isFloat = true}},
    };
    const std::string wanted = "|" + std::string(name) + "|";
    for (const Names& known : kTypes)
        if (known.names.find(wanted) != std::string_view::npos) return known.type;
    return std::nullopt;
}

Result<void> readType(const Fields& fields, NrrdHeader& header) {
    const auto type = fields.find("type");
    if (type == fields.end()) return malformed("type", "it has no type");
    header.typeName = lowerCase(type->second);
    const auto known = typeNamed(header.typeName);
    if (!known)
        return unsupported("type", "values of type '" + cleanText(type->second) +
                                       "' are not supported: labels are whole numbers");
    header.type = *known;
    if (known->bytes == 1) return {};
    const auto endian = fields.find("endian");
    const std::string order = endian == fields.end() ? "" : lowerCase(endian->second);
    if (order != "little" && order != "big" && header.encoding != NrrdEncoding::text)
        return malformed("endian", "values of several bytes need endian, little or big");
    header.type.bigEndian = order == "big";
    return {};
}

Result<void> readEncoding(const Fields& fields, NrrdHeader& header) {
    const auto found = fields.find("encoding");
    if (found == fields.end()) return malformed("encoding", "it has no encoding");
    const std::string encoding = lowerCase(found->second);
    if (encoding == "gzip" || encoding == "gz") {
        header.encoding = NrrdEncoding::gzip;
    } else if (encoding == "text" || encoding == "txt" || encoding == "ascii") {
        header.encoding = NrrdEncoding::text;
    } else if (encoding != "raw") {
        return unsupported("encoding", "NRRD values in the encoding '" + cleanText(encoding) +
                                           "' are not supported; raw, gzip and text are");
    }
    return {};
}

Result<void> readSizes(const Fields& fields, NrrdHeader& header) {
    const auto dimension = fields.find("dimension");
    const auto sizes = fields.find("sizes");
    if (dimension == fields.end() || sizes == fields.end())
        return malformed("sizes", "it has no dimension or no sizes");
    const auto list = words(sizes->second);
    const auto axes = numberIn<std::uint32_t>(dimension->second);
    if (!axes || *axes != list.size())
        return malformed("sizes", "dimension and sizes do not fit together");
    if (*axes == 4)
        return unsupported(
            "dimension",
            "the volume has 4 axes: time, colours, or segments that overlap; a label "
            "grid has 3 (in 3D Slicer, collapse the layers of the segmentation)");
    if (*axes != 3)
        return unsupported("dimension",
                           "the volume has " + std::to_string(*axes) + " axes; a label grid has 3");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto size = numberIn<std::uint64_t>(list[axis]);
        if (!size) return malformed("sizes", "'" + cleanText(list[axis]) + "' is no size");
        header.size[static_cast<int>(axis)] =
            static_cast<int>(std::min<std::uint64_t>(*size, std::numeric_limits<int>::max()));
    }
    return {};
}

/// "(1,0,0)"
std::optional<Vec3d> vectorIn(std::string_view text) {
    if (!text.starts_with('(') || !text.ends_with(')')) return std::nullopt;
    text = text.substr(1, text.size() - 2);
    Vec3d vector;
    for (int i = 0; i < 3; ++i) {
        const std::size_t end = i < 2 ? text.find(',') : text.size();
        if (end == std::string_view::npos) return std::nullopt;
        const auto number = numberIn<double>(trimmed(text.substr(0, end)));
        if (!number) return std::nullopt;
        vector[i] = *number;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return vector;
}

/// Vectors may have blanks inside.
std::vector<std::string_view> vectorsIn(std::string_view text) {
    std::vector<std::string_view> list;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const std::size_t close = std::min(text.find(')'), text.size() - 1);
        list.push_back(text.substr(0, close + 1));
        text.remove_prefix(close + 1);
    }
    return list;
}

/// Which axes of the file's space go the other way than right, forward and up.
Vec3d signsOf(const std::string& space) {
    if (space == "left-anterior-superior" || space == "las") return {-1, 1, 1};
    if (space == "left-posterior-superior" || space == "lps") return {-1, -1, 1};
    return Vec3d::Ones();
}

Result<void> readSteps(const Fields& fields, NrrdHeader& header) {
    const auto spacings = fields.find("spacings");
    if (spacings != fields.end()) {
        const auto list = words(spacings->second);
        for (std::size_t axis = 0; axis < std::min<std::size_t>(list.size(), 3); ++axis) {
            const auto side = numberIn<double>(list[axis]);
            if (!side) return malformed("spacings", "'" + cleanText(list[axis]) + "' is no number");
            if (!std::isnan(*side)) header.steps[axis] *= std::abs(*side);
        }
    }
    const auto space = fields.find("space");
    const Vec3d signs =
        space == fields.end() ? Vec3d(Vec3d::Ones()) : signsOf(lowerCase(space->second));
    const auto directions = fields.find("spacedirections");
    if (directions == fields.end()) return {};
    const auto list = vectorsIn(directions->second);
    if (list.size() != 3) return malformed("space directions", "three vectors are needed");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto step = vectorIn(list[axis]);
        if (!step)
            return malformed("space directions", "'" + cleanText(list[axis]) + "' is no vector");
        header.steps[axis] = step->cwiseProduct(signs);
    }
    return {};
}

Result<void> readSkips(const Fields& fields, NrrdHeader& header) {
    if (fields.contains("datafile"))
        return unsupported("data file",
                           "the header names a data file: send one file with header and values");
    if (const auto skip = fields.find("lineskip"); skip != fields.end()) {
        const auto lines = numberIn<std::uint64_t>(skip->second);
        if (!lines) return malformed("line skip", "'" + cleanText(skip->second) + "' is no count");
        header.lineSkip = *lines;
    }
    if (const auto skip = fields.find("byteskip"); skip != fields.end()) {
        const auto bytes = numberIn<std::int64_t>(skip->second);
        const bool last = bytes && *bytes == -1 && header.encoding == NrrdEncoding::raw;
        if (!bytes || (*bytes < 0 && !last))
            return malformed("byte skip", "'" + cleanText(skip->second) + "' is no count");
        header.byteSkip = last ? std::nullopt : std::optional<std::uint64_t>(*bytes);
    }
    return {};
}

/// A value of a key: a line break is written as "\n".
std::string unescaped(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool escape = text[i] == '\\' && i + 1 < text.size();
        if (escape) ++i;
        out += escape && text[i] == 'n' ? ' ' : text[i];
    }
    return cleanText(out);
}

std::optional<Rgba8> colorIn(std::string_view text) {
    const auto list = words(text);
    if (list.size() != 3) return std::nullopt;
    Rgba8 color{0, 0, 0, 255};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto part = numberIn<double>(list[i]);
        if (!part || !(*part >= 0 && *part <= 1)) return std::nullopt;
        color[i] = static_cast<std::uint8_t>(std::lround(*part * 255));
    }
    return color;
}

/// "Segment3_Name" and the like; what says nothing is left alone, as other keys are.
Result<void> readSegments(const Fields& keys, NrrdHeader& header) {
    for (const auto& [key, value] : keys) {
        const std::size_t underscore = key.find('_');
        constexpr std::size_t kPrefix = std::string_view("Segment").size();
        if (underscore == std::string::npos) continue;
        const auto number =
            numberIn<std::uint32_t>(std::string_view(key).substr(kPrefix, underscore - kPrefix));
        if (!number) continue;
        const std::string_view what = std::string_view(key).substr(underscore + 1);
        if (what == "Layer" && trimmed(value) != "0")
            return unsupported(
                "segments",
                "the segments overlap, in several layers; in 3D Slicer, collapse the "
                "layers of the segmentation");
        NrrdSegment& segment = header.segments[*number];
        if (what == "Name") segment.name = unescaped(value);
        if (what == "Color") segment.color = colorIn(value);
        if (what == "LabelValue") segment.value = numberIn<std::uint32_t>(trimmed(value));
    }
    return {};
}

}  // namespace

Result<NrrdHeader> parseNrrdHeader(std::span<const std::byte> bytes) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    NrrdHeader header;
    const auto version = text.starts_with("NRRD") && text.size() > 8
                             ? numberIn<std::uint32_t>(text.substr(4, 4))
                             : std::nullopt;
    if (!version || *version < 1 || *version > 6 || (text[8] != '\n' && text[8] != '\r'))
        return fail(ErrorCode::unsupportedFormat,
                    "the file does not begin with NRRD0001 to NRRD0006", "/grid");
    header.version = static_cast<int>(*version);
    const auto lines = readLines(text);
    if (!lines) return fail(lines.error());
    header.dataOffset = lines->bytes;
    for (const auto read : {readEncoding, readType, readSizes, readSteps, readSkips})
        if (auto done = read(lines->fields, header); !done) return fail(done.error());
    if (auto done = readSegments(lines->keys, header); !done) return fail(done.error());
    return header;
}

}  // namespace rivage::core
