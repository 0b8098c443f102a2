#include "core/formats/write_nrrd.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace rivage::core {
namespace {

constexpr std::size_t kBuffer = 1 << 16;
constexpr int kLevel = 6;  // zlib's own choice between size and time

tl::unexpected<Error> tooLong(std::uint64_t bytes, const Limits& limits) {
    return fail(Error{ErrorCode::outputTooLarge,
                      "the volume has " + std::to_string(bytes) + " bytes, at most " +
                          std::to_string(limits.maxOutputBytes) + " are allowed",
                      "/options/scale", limits.maxOutputBytes, bytes});
}

/// The shortest text that reads back as the same number.
std::string text(double value) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value + 0.0).ptr;
    return {buffer.data(), end};
}

std::string text(const Vec3d& v) {
    return "(" + text(v.x()) + "," + text(v.y()) + "," + text(v.z()) + ")";
}

/// A value of a key, on one line.
std::string escaped(std::string_view value) {
    std::string out;
    for (const char c : value) {
        if (c == '\\')
            out += "\\\\";
        else if (c == '\n')
            out += "\\n";
        else if (c != '\r')
            out += c;
    }
    return out;
}

/// By label, the colour that most of its voxels have; means nothing once `run` asked to stop.
std::vector<Rgba8> commonColors(const VoxelGrid& grid, const RunContext& run) {
    std::vector<std::uint64_t> voxels(grid.materials.size(), 0);
    grid.voxels.forEachUntil([&] { return run.stopped(); },
                             [&](const Vec3i&, MaterialId m) { ++voxels[index(m)]; });
    std::vector<Rgba8> colors(grid.labels.size(), Rgba8{128, 128, 128, 255});
    std::vector<std::uint64_t> most(grid.labels.size(), 0);
    for (std::size_t m = 1; m < grid.materials.size(); ++m) {
        const std::size_t label = index(grid.materials.raw()[m].label);
        if (voxels[m] <= most[label]) continue;
        most[label] = voxels[m];
        colors[label] = grid.materials.raw()[m].color;
    }
    return colors;
}

std::string headerOf(const VoxelGrid& grid, const VolumePlace& place, bool packed,
                     const std::vector<Rgba8>& colors) {
    const Vec3i& size = grid.voxels.size();
    const bool wide = grid.labels.size() > 256;
    std::string header = "NRRD0005\n# Written by Rivage\n";
    header += wide ? "type: uint16\nendian: little\n" : "type: uint8\n";
    header += "dimension: 3\nspace: right-anterior-superior\nsizes:";
    for (int axis = 0; axis < 3; ++axis) header += " " + std::to_string(size[axis]);
    header += "\nspace directions:";
    for (int axis = 0; axis < 3; ++axis)
        header += " " + text(Vec3d(place.spacing[axis] * Vec3d::Unit(axis)));
    header += "\nspace units: \"mm\" \"mm\" \"mm\"\nkinds: domain domain domain\n";
    header += "space origin: " + text(place.origin) + "\n";
    header += packed ? "encoding: gzip\n" : "encoding: raw\n";
    header +=
        "Segmentation_SourceRepresentation:=Binary labelmap\n"
        "Segmentation_MasterRepresentation:=Binary labelmap\n"  // its name before Slicer 5
        "Segmentation_ContainedRepresentationNames:=Binary labelmap|\n"
        "Segmentation_ReferenceImageExtentOffset:=0 0 0\n";
    std::string extent;
    for (int axis = 0; axis < 3; ++axis)
        extent += (axis ? " 0 " : "0 ") + std::to_string(size[axis] - 1);
    for (std::size_t l = 1; l < grid.labels.size(); ++l) {
        const std::string key = "Segment" + std::to_string(l - 1) + "_";
        header += key + "ID:=Segment_" + std::to_string(l) + "\n";
        header += key + "Name:=" + escaped(grid.labels.raw()[l]) + "\n";
        header += key + "Color:=";
        for (int i = 0; i < 3; ++i) header += (i ? " " : "") + text(colors[l][i] / 255.0);
        header += "\n" + key + "LabelValue:=" + std::to_string(l) + "\n";
        header += key + "Layer:=0\n";
        header += key + "Extent:=" + extent + "\n";
    }
    return header + "\n";
}

/// Takes bytes, and keeps them packed or as they are.
class Packer {
public:
    Packer(std::vector<std::byte>& out, bool packed) : out_(out), packed_(packed) {
        constexpr int kGzip = 15 + 16;  // the largest window, with a gzip header
        if (packed_)
            ready_ =
                deflateInit2(&stream_, kLevel, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) == Z_OK;
    }
    Packer(const Packer&) = delete;
    Packer& operator=(const Packer&) = delete;
    ~Packer() {
        if (packed_ && ready_) deflateEnd(&stream_);
    }

    void add(std::span<const std::byte> bytes, bool last) {
        if (!packed_) {
            out_.insert(out_.end(), bytes.begin(), bytes.end());
            return;
        }
        if (!ready_) return;
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
        stream_.avail_in = static_cast<uInt>(bytes.size());
        do {
            stream_.next_out = reinterpret_cast<Bytef*>(buffer_.data());
            stream_.avail_out = static_cast<uInt>(buffer_.size());
            deflate(&stream_, last ? Z_FINISH : Z_NO_FLUSH);
            const auto made = static_cast<std::ptrdiff_t>(buffer_.size() - stream_.avail_out);
            out_.insert(out_.end(), buffer_.begin(), buffer_.begin() + made);
        } while (stream_.avail_out == 0);
    }
    [[nodiscard]] bool ready() const { return ready_; }

private:
    std::vector<std::byte>& out_;
    bool packed_;
    bool ready_ = true;
    z_stream stream_{};
    std::vector<std::byte> buffer_ = std::vector<std::byte>(kBuffer);
};

}  // namespace

std::uint64_t nrrdVolumeBytes(const Vec3i& size, std::size_t labels) {
    const std::uint64_t voxels = static_cast<std::uint64_t>(size.x()) * size.y() * size.z();
    return voxels * (labels > 255 ? 2 : 1);
}

Result<std::vector<std::byte>> writeNrrd(const VoxelGrid& grid, const VolumePlace& place,
                                         bool packed, const RunContext& run) {
    const Vec3i& size = grid.voxels.size();
    const std::uint64_t bytes = nrrdVolumeBytes(size, grid.labels.size() - 1);
    if (bytes > run.limits.maxOutputBytes) return tooLong(bytes, run.limits);
    const bool wide = grid.labels.size() > 256;
    const std::string header = headerOf(grid, place, packed, commonColors(grid, run));
    std::vector<std::byte> out(header.size());
    std::transform(header.begin(), header.end(), out.begin(),
                   [](char c) { return static_cast<std::byte>(c); });
    if (!packed) out.reserve(out.size() + bytes);

    Packer packer(out, packed);
    std::vector<MaterialId> row(static_cast<std::size_t>(size.x()));
    std::vector<std::byte> values;
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y) {
            if (run.stopped()) return fail(run.stopError());
            grid.voxels.copyRow(0, y, z, row);
            values.clear();
            for (const MaterialId material : row) {
                const std::uint16_t label = index(grid.materials[material].label);
                values.push_back(static_cast<std::byte>(label & 0xff));
                if (wide) values.push_back(static_cast<std::byte>(label >> 8));
            }
            packer.add(values, z + 1 == size.z() && y + 1 == size.y());
        }
    if (!packer.ready()) return fail(ErrorCode::internal, "the volume could not be packed");
    if (out.size() > run.limits.maxOutputBytes) return tooLong(out.size(), run.limits);
    return out;
}

}  // namespace rivage::core
