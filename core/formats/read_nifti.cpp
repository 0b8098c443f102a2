#include "core/formats/read_nifti.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "core/formats/label_volume.h"
#include "core/formats/volume_frame.h"

namespace rivage::core {
namespace {

using namespace std::string_view_literals;

/// Where the fields of a header are, by version; the numbers of version 2 are twice as wide or more.
struct Layout {
    std::size_t bytes;
    std::size_t magic;
    std::size_t dim;
    std::size_t type;
    std::size_t pixdim;
    std::size_t offset;
    std::size_t slope;
    std::size_t forms;  ///< qform_code; sform_code follows
    std::size_t quaternion;
    std::size_t rows;
};
constexpr Layout kLayouts[] = {
    {348, 344, 40, 70, 76, 108, 112, 252, 256, 280},
    {540, 4, 16, 12, 104, 168, 176, 344, 352, 400},
};
constexpr std::string_view kMagic[] = {"n+1\0"sv, "n+2\0\r\n\x1a\n"sv};
constexpr std::string_view kPairMagic[] = {"ni1\0"sv, "ni2\0\r\n\x1a\n"sv};

std::string_view textOf(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The header of a file, as it lies there.
class Header {
public:
    Header(std::span<const std::byte> bytes, std::size_t version, bool bigEndian)
        : bytes_(bytes), layout_(kLayouts[version]), wide_(version == 1), big_(bigEndian) {}

    [[nodiscard]] int version() const { return wide_ ? 2 : 1; }
    [[nodiscard]] bool bigEndian() const { return big_; }
    [[nodiscard]] std::size_t bytes() const { return layout_.bytes; }
    [[nodiscard]] std::int64_t dim(std::size_t i) const {
        return wide_ ? integer(layout_.dim + 8 * i, 8) : integer(layout_.dim + 2 * i, 2);
    }
    [[nodiscard]] std::int64_t type() const { return integer(layout_.type, 2); }
    [[nodiscard]] double pixdim(std::size_t i) const { return real(layout_.pixdim, i); }
    [[nodiscard]] double offset() const {
        return wide_ ? static_cast<double>(integer(layout_.offset, 8)) : real(layout_.offset, 0);
    }
    [[nodiscard]] double slope() const { return real(layout_.slope, 0); }
    [[nodiscard]] double intercept() const { return real(layout_.slope, 1); }
    [[nodiscard]] std::int64_t form(std::size_t which) const {
        const std::size_t width = wide_ ? 4 : 2;
        return integer(layout_.forms + width * which, width);
    }
    [[nodiscard]] double quaternion(std::size_t i) const { return real(layout_.quaternion, i); }
    [[nodiscard]] double row(std::size_t r, std::size_t c) const {
        return real(layout_.rows, 4 * r + c);
    }

private:
    [[nodiscard]] std::uint64_t raw(std::size_t at, std::size_t width) const {
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < width; ++i)
            value = value << 8 |
                    std::to_integer<std::uint64_t>(bytes_[at + (big_ ? i : width - 1 - i)]);
        return value;
    }
    [[nodiscard]] std::int64_t integer(std::size_t at, std::size_t width) const {
        const auto shift = static_cast<unsigned>(64 - 8 * width);
        return static_cast<std::int64_t>(raw(at, width) << shift) >> shift;
    }
    [[nodiscard]] double real(std::size_t at, std::size_t i) const {
        if (wide_) return std::bit_cast<double>(raw(at + 8 * i, 8));
        return std::bit_cast<float>(static_cast<std::uint32_t>(raw(at + 4 * i, 4)));
    }

    std::span<const std::byte> bytes_;
    const Layout& layout_;
    bool wide_;
    bool big_;
};

/// The version (0 or 1) of the file whose header has this magic.
std::optional<std::size_t> versionBy(std::span<const std::byte> bytes,
                                     const std::string_view (&magic)[2]) {
    for (std::size_t version = 0; version < 2; ++version) {
        const Layout& layout = kLayouts[version];
        if (bytes.size() >= layout.bytes &&
            textOf(bytes).substr(layout.magic).starts_with(magic[version]))
            return version;
    }
    return std::nullopt;
}

std::optional<ValueType> typeOf(std::int64_t code) {
    switch (code) {
        case 2: return ValueType{.bytes = 1};
        case 4: return ValueType{.bytes = 2, .isSigned = true};
        case 8: return ValueType{.bytes = 4, .isSigned = true};
        case 16: return ValueType{.bytes = 4, .isFloat = true};
        case 64: return ValueType{.bytes = 8, .isFloat = true};
        case 256: return ValueType{.bytes = 1, .isSigned = true};
        case 512: return ValueType{.bytes = 2};
        case 768: return ValueType{.bytes = 4};
        case 1024: return ValueType{.bytes = 8, .isSigned = true};
        case 1280: return ValueType{.bytes = 8};
        default: return std::nullopt;
    }
}

Result<Vec3i> sizeOf(const Header& header) {
    constexpr std::int64_t kMostAxes = 7;
    const std::int64_t axes = header.dim(0);
    if (axes < 1 || axes > kMostAxes)
        return fail(ErrorCode::malformedInput, "the NIfTI header: dim[0] is not 1 to 7",
                    "/grid/header/dim");
    Vec3i size = Vec3i::Ones();
    for (std::size_t i = 1; i <= static_cast<std::size_t>(axes); ++i) {
        const std::int64_t side = header.dim(i);
        if (i > 3 && side > 1)
            return fail(
                ErrorCode::unsupportedFormat,
                "the volume has more than three axes (time, or vectors); a label grid has 3",
                "/grid/header/dim");
        if (i <= 3)
            size[static_cast<int>(i) - 1] = static_cast<int>(
                std::clamp<std::int64_t>(side, 0, std::numeric_limits<int>::max()));
    }
    return size;
}

VolumeSteps stepsOf(const Header& header) {
    VolumeSteps steps;
    if (header.form(1) > 0) {
        for (std::size_t c = 0; c < 3; ++c)
            steps[c] = Vec3d(header.row(0, c), header.row(1, c), header.row(2, c));
        return steps;
    }
    Mat3d rotation = Mat3d::Identity();
    if (header.form(0) > 0) {
        const double b = header.quaternion(0);
        const double c = header.quaternion(1);
        const double d = header.quaternion(2);
        const double a = std::sqrt(std::max(0.0, 1 - b * b - c * c - d * d));
        rotation = Eigen::Quaterniond(a, b, c, d).toRotationMatrix();
        if (header.pixdim(0) < 0) rotation.col(2) *= -1;
    }
    for (std::size_t c = 0; c < 3; ++c)
        steps[c] = std::abs(header.pixdim(c + 1)) * rotation.col(static_cast<int>(c));
    return steps;
}

/// Where the values begin.
Result<std::size_t> dataOffset(const Header& header, std::size_t bytes) {
    const double offset = header.offset();
    constexpr double kExtension = 4;  // what at least stands between the header and the values
    const double least = static_cast<double>(header.bytes()) + kExtension;
    if (!std::isfinite(offset) || offset > static_cast<double>(bytes))
        return fail(ErrorCode::malformedInput,
                    "the NIfTI header: vox_offset is beyond the end of the file",
                    "/grid/header/vox_offset");
    return static_cast<std::size_t>(std::max(offset, least));
}

Result<void> checkScaling(const Header& header) {
    const double slope = header.slope();
    if (slope == 0 || std::isnan(slope) || (slope == 1 && header.intercept() == 0)) return {};
    return fail(ErrorCode::unsupportedFormat,
                "the values are scaled (scl_slope, scl_inter), so they are no labels",
                "/grid/header/scl_slope");
}

}  // namespace

bool isNifti(std::span<const std::byte> bytes) {
    return versionBy(bytes, kMagic) || versionBy(bytes, kPairMagic);
}

Result<Scene> readNifti(std::span<const std::byte> bytes, const RunContext& run) {
    const auto version = versionBy(bytes, kMagic);
    if (!version && versionBy(bytes, kPairMagic))
        return fail(ErrorCode::unsupportedFormat,
                    "the values are in a second file (.img): save one .nii", "/grid");
    if (!version) return fail(ErrorCode::malformedInput, "the file has no NIfTI header", "/grid");
    const bool bigEndian = bytes[0] == std::byte{0};  // sizeof_hdr is 348 or 540
    const Header header(bytes, *version, bigEndian);
    auto type = typeOf(header.type());
    if (!type)
        return fail(ErrorCode::unsupportedFormat,
                    "NIfTI values of datatype " + std::to_string(header.type()) +
                        " are not supported: labels are whole numbers",
                    "/grid/header/datatype");
    type->bigEndian = bigEndian;
    const auto size = sizeOf(header);
    if (!size) return fail(size.error());
    const auto needed =
        checkVolumeSize(*size, *type, run.limits, ErrorCode::malformedInput, "/grid/header/dim");
    if (!needed) return fail(needed.error());
    if (auto scaled = checkScaling(header); !scaled) return fail(scaled.error());
    const auto offset = dataOffset(header, bytes.size());
    if (!offset) return fail(offset.error());
    const std::uint64_t stored = bytes.size() - std::min(*offset, bytes.size());
    if (stored < *needed)
        return fail(Error{ErrorCode::malformedInput,
                          "dim asks for " + std::to_string(*needed) +
                              " bytes of values and the file has " + std::to_string(stored),
                          "/grid", *needed, stored});
    auto scene = sceneFromVolume(bytes.subspan(*offset, static_cast<std::size_t>(*needed)), *type,
                                 *size, run);
    if (!scene) return scene;
    if (auto placed = placeVolume(*scene, stepsOf(header), "/grid/header/pixdim"); !placed)
        return fail(placed.error());
    scene->format = GridFormat::nifti;
    scene->formatDetail = "nifti " + std::to_string(header.version());
    return scene;
}

}  // namespace rivage::core
