#include "core/formats/npy_header.h"

#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "core/formats/byte_reader.h"

namespace rivage::core {
namespace {

constexpr std::size_t kMaxHeaderBytes = 65536;
constexpr std::size_t kMaxDimensions = 32;

tl::unexpected<Error> malformed(std::string message) {
    return fail(ErrorCode::malformedInput, std::move(message), "/grid/header");
}

/// The few literals of Python that such a header is made of.
class LiteralReader {
public:
    explicit LiteralReader(std::string_view text) : text_(text) {}

    bool take(char expected) {
        skipSpace();
        if (text_.empty() || text_.front() != expected) return false;
        text_.remove_prefix(1);
        return true;
    }
    [[nodiscard]] bool sees(char expected) {
        skipSpace();
        return !text_.empty() && text_.front() == expected;
    }
    std::optional<std::string> string() {
        skipSpace();
        if (text_.empty() || (text_.front() != '\'' && text_.front() != '"')) return std::nullopt;
        const std::size_t end = text_.find(text_.front(), 1);
        if (end == std::string_view::npos) return std::nullopt;
        std::string value(text_.substr(1, end - 1));
        text_.remove_prefix(end + 1);
        return value;
    }
    std::optional<bool> boolean() {
        skipSpace();
        for (const bool value : {false, true}) {
            const std::string_view word = value ? "True" : "False";
            if (!text_.starts_with(word)) continue;
            text_.remove_prefix(word.size());
            return value;
        }
        return std::nullopt;
    }
    std::optional<std::uint64_t> number() {
        skipSpace();
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
        if (error != std::errc()) return std::nullopt;
        text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
        return value;
    }
    std::optional<std::vector<std::uint64_t>> tuple() {
        if (!take('(')) return std::nullopt;
        std::vector<std::uint64_t> values;
        while (!take(')')) {
            const std::optional<std::uint64_t> value = number();
            if (!value || values.size() == kMaxDimensions) return std::nullopt;
            values.push_back(*value);
            if (!take(',') && !sees(')')) return std::nullopt;
        }
        return values;
    }
    [[nodiscard]] bool atEnd() {
        skipSpace();
        return text_.empty();
    }

private:
    void skipSpace() {
        while (!text_.empty() && (text_.front() == ' ' || text_.front() == '\n'))
            text_.remove_prefix(1);
    }
    std::string_view text_;
};

Result<NpyHeader> parseDictionary(std::string_view text) {
    LiteralReader reader(text);
    std::optional<std::string> descr;
    std::optional<bool> fortranOrder;
    std::optional<std::vector<std::uint64_t>> shape;
    if (!reader.take('{')) return malformed("the .npy header is not a dictionary");
    while (!reader.take('}')) {
        const std::optional<std::string> key = reader.string();
        if (!key || !reader.take(':')) return malformed("the .npy header has a malformed key");
        if (*key == "descr" && reader.sees('['))
            return fail(ErrorCode::unsupportedFormat,
                        "structured .npy arrays are not supported: save one integer array",
                        "/grid/header");
        const bool known = *key == "descr"           ? (descr = reader.string()).has_value()
                           : *key == "fortran_order" ? (fortranOrder = reader.boolean()).has_value()
                           : *key == "shape"         ? (shape = reader.tuple()).has_value()
                                                     : false;
        if (!known) return malformed("the .npy header has an unexpected or malformed entry");
        if (!reader.take(',') && !reader.sees('}'))
            return malformed("the .npy header lacks a comma");
    }
    if (!reader.atEnd()) return malformed("text follows the dictionary of the .npy header");
    if (!descr || !fortranOrder || !shape)
        return malformed("the .npy header must have descr, fortran_order and shape");
    NpyHeader header;
    header.descr = *std::move(descr);
    header.fortranOrder = *fortranOrder;
    header.shape = *std::move(shape);
    return header;
}

}  // namespace

Result<NpyHeader> parseNpyHeader(std::span<const std::byte> bytes) {
    ByteReader reader(bytes);
    if (reader.text(6) != "\x93NUMPY")
        return malformed("the file does not start with '\\x93NUMPY'");
    const auto versionBytes = reader.bytes(2);
    if (!reader.ok()) return malformed("the file ends inside its header");
    const int version = std::to_integer<int>(versionBytes[0]);
    if (version < 1 || version > 3)
        return fail(
            ErrorCode::unsupportedFormat,
            ".npy version " + std::to_string(version) + " is not supported; versions 1 to 3 are",
            "/grid/header");
    std::uint64_t length = 0;
    if (version == 1) {
        for (int i = 0; const std::byte b : reader.bytes(2))
            length |= std::to_integer<std::uint64_t>(b) << (8 * i++);
    } else {
        length = reader.u32();
    }
    if (length > kMaxHeaderBytes) return malformed("the .npy header is longer than 65536 bytes");
    const std::string_view text = reader.text(length);
    if (!reader.ok()) return malformed("the file ends inside its header");
    Result<NpyHeader> header = parseDictionary(text);
    if (!header) return header;
    header->version = version;
    header->dataOffset = reader.offset();
    return header;
}

}  // namespace rivage::core
