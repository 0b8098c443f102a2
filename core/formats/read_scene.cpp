#include "core/formats/read_scene.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "core/formats/inflate.h"
#include "core/formats/read_nifti.h"
#include "core/formats/read_npy.h"
#include "core/formats/read_nrrd.h"
#include "core/formats/read_raw.h"
#include "core/formats/read_vol.h"
#include "core/formats/read_vox.h"

namespace rivage::core {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kVoxMagic = "VOX "sv;
constexpr std::string_view kNpyMagic = "\x93NUMPY"sv;
constexpr std::string_view kNrrdMagic = "NRRD000"sv;

/// Formats that are often sent by mistake, and what to do instead.
struct KnownStranger {
    std::string_view magic;
    std::string_view advice;
};
constexpr KnownStranger kStrangers[] = {
    {"\x1f\x8b"sv, "this is gzip data in gzip data"sv},
    {"\x28\xb5\x2f\xfd"sv,
     "this is Zstandard data: decompress it, or send it with Content-Encoding: zstd"sv},
    {"PK\x03\x04"sv, "this is a ZIP archive (or an .npz): send the file inside it"sv},
    {"\x89PNG"sv, "this is a PNG image, not a voxel grid"sv},
    {"glTF"sv, "this is a GLB mesh; a voxel grid is needed"sv},
    {"GOX "sv, "this is a Goxel file: export it as MagicaVoxel .vox"sv},
    {"\x89HDF"sv, "this is an HDF5 file: save the label array as .npy"sv},
    {"ply"sv, "this is a PLY mesh; a voxel grid is needed"sv},
    {"{"sv, "this looks like JSON; send the grid as the body, or as the form part 'grid'"sv},
};

tl::unexpected<Error> unknownFormat(std::string_view head) {
    std::string message;
    for (const KnownStranger& stranger : kStrangers)
        if (message.empty() && head.starts_with(stranger.magic))
            message = std::string(stranger.advice) + ". ";
    message +=
        "Formats read: MagicaVoxel (.vox, versions 150 and 200), NumPy (.npy, three axes "
        "of integers), NRRD (.nrrd, .seg.nrrd), NIfTI (.nii), .vol and .longvol, each also "
        "packed by gzip, and raw volumes with format=raw and dims";
    return fail(ErrorCode::unsupportedFormat, std::move(message), "/grid");
}

tl::unexpected<Error> tooManyBytes(std::uint64_t bytes, const Limits& limits) {
    return fail(Error{ErrorCode::tooLarge,
                      "the grid has " + std::to_string(bytes) + " bytes or more, at most " +
                          std::to_string(limits.maxInputBytes) + " are allowed",
                      "/grid", limits.maxInputBytes, bytes, "--max-upload"});
}

/// What is not packed.
Result<Scene> readPlain(std::span<const std::byte> bytes, const InputOptions& options,
                        const RunContext& run) {
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                                std::min<std::size_t>(bytes.size(), 16));
    switch (options.format) {
        case GridFormat::vox: return readVox(bytes, options, run);
        case GridFormat::npy: return readNpy(bytes, run);
        case GridFormat::nrrd: return readNrrd(bytes, run);
        case GridFormat::nifti: return readNifti(bytes, run);
        case GridFormat::vol: return readVol(bytes, run);
        case GridFormat::raw: return readRaw(bytes, options, run);
        case GridFormat::automatic: break;
    }
    if (head.starts_with(kVoxMagic)) return readVox(bytes, options, run);
    if (head.starts_with(kNpyMagic)) return readNpy(bytes, run);
    if (head.starts_with(kNrrdMagic)) return readNrrd(bytes, run);
    if (isNifti(bytes)) return readNifti(bytes, run);
    if (isVol(bytes)) return readVol(bytes, run);
    return unknownFormat(head);
}

}  // namespace

Result<Scene> readScene(std::span<const std::byte> bytes, const InputOptions& options,
                        const RunContext& run) {
    if (bytes.size() > run.limits.maxInputBytes) return tooManyBytes(bytes.size(), run.limits);
    if (bytes.empty()) return fail(ErrorCode::malformedInput, "the grid has no bytes", "/grid");
    if (options.format == GridFormat::raw || !isGzip(bytes)) return readPlain(bytes, options, run);
    const auto unpacked = inflateUpTo(bytes, run.limits.maxInputBytes + 1, run);
    if (!unpacked) return fail(unpacked.error());
    if (unpacked->size() > run.limits.maxInputBytes)
        return tooManyBytes(unpacked->size(), run.limits);
    return readPlain(*unpacked, options, run);
}

}  // namespace rivage::core
