#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/ids.h"
#include "core/base/vec.h"

/// Every option of a conversion as a plain, validated value. `proto/options.h` parses them from
/// the wire and lists them with their ranges; the stages of `core/` read them.
namespace rivage::core {

enum class GridFormat : std::uint8_t { automatic, vox, npy, nrrd, nifti, vol, raw };
enum class RawType : std::uint8_t { u8, u16 };
enum class LabelMode : std::uint8_t { automatic, solid, material, palette, map };
enum class Border : std::uint8_t { closed, open };

/// The most that the sides of a voxel may differ: longest by shortest.
inline constexpr double kMaxSpacingRatio = 100;

/// One label of an explicit label map: its name and the palette entries (.vox) or stored values
/// (other formats) that it takes; `rest` takes whatever no other label takes.
struct LabelRule {
    std::string name;
    std::vector<std::uint32_t> values;
    bool rest = false;
};

struct InputOptions {
    GridFormat format = GridFormat::automatic;
    std::optional<Vec3i> dims;      ///< raw only: voxels along x, y, z
    RawType rawType = RawType::u8;  ///< raw only: little-endian, x fastest
    LabelMode labels = LabelMode::automatic;
    std::vector<LabelRule> labelMap;  ///< with `LabelMode::map`
    bool keepHidden = false;          ///< hidden layers, groups and shapes are converted too
    int frame = 0;                    ///< which model of a shape with several frames
    /// Outside the grid is background, or the grid is a cutout and its border no surface.
    Border border = Border::closed;
    /// Relative sides of a voxel, see `kMaxSpacingRatio`; nothing: as the file says, else equal.
    std::optional<Vec3d> spacing;
};

enum class NormalMethod : std::uint8_t {
    automatic,
    guided,
    discVote,
    convolved,
    integralInvariant,
    piecewiseSmooth,
    robust,
    trivial
};
enum class Fairness : std::uint8_t { umbrella, tangential };
enum class JunctionFairness : std::uint8_t { umbrella, curve };
enum class Preset : std::uint8_t { studio, paper, organic, architectural, noisy };

/// The weights of the Ambrosio-Tortorelli functional.
struct PiecewiseSmoothOptions {
    double alpha = 0.1;     ///< the smaller, the larger the area that is smoothed over
    double lambda = 0.025;  ///< the smaller, the longer the features that it may have
};
enum class SolverKind : std::uint8_t {
    automatic,
    pcg,
    multigrid,
    projected,
    accelerated,
    gradientDescent,
    cholesky
};

struct NormalOptions {
    NormalMethod method = NormalMethod::automatic;
    std::optional<double> radius;  ///< voxels; none: what suits the method
    PiecewiseSmoothOptions piecewiseSmooth = {};
};

/// Factors of the weights in one region; "*" stands for every region that is not named.
struct RegionWeights {
    std::string region;
    double alpha = 1;
    double beta = 1;
    double gamma = 1;
};

struct EnergyOptions {
    double alpha = 0.01;
    double beta = 1;
    double gamma = 0.05;
    Fairness fairness = Fairness::tangential;
    JunctionFairness junctionFairness = JunctionFairness::curve;
    bool split = true;                        ///< sheets that only touch get pointels of their own
    std::vector<RegionWeights> regions = {};  ///< each name once
};

struct SolveOptions {
    SolverKind solver = SolverKind::automatic;
    std::optional<double> displacementLimit = 0.49;  ///< voxels, sup norm
    double tolerance = 1e-6;  ///< of the relative residual (of the KKT conditions with a limit)
    int maxIterations = 5000;
    bool untangle = true;
};

struct MethodOptions {
    NormalOptions normals = {};
    EnergyOptions energy = {};
    SolveOptions solve = {};
};

/// The method options that a preset stands for.
/// @source METHOD.md section 8; [CGL18] for `paper`
[[nodiscard]] MethodOptions presetOptions(Preset preset);

/// The height tiles that the project makes itself; `own` has the heights of the caller.
enum class TileKind : std::uint8_t { own, brick, planks, shingles, pantiles, cobble, panels };

/// A height tile: repeated along the surface, it says how far the surface stands out.
struct TileOptions {
    TileKind kind = TileKind::own;
    /// Own heights: rows from top to bottom, 0 lowest .. 1 highest; all rows equally long.
    std::vector<std::vector<double>> heights = {};
    std::optional<double> size;   ///< width of a repetition, voxels; none: what suits the tile
    std::optional<double> depth;  ///< from height 0 to height 1, voxels; none: as above
    int turn = 0;                 ///< degrees counter-clockwise: 0, 90, 180 or 270
};

/// Which tile a material gets: named by a palette entry (.vox) or stored value, by the name of the
/// material, by a region, or "*" for every other; in this order of precedence.
struct EmbossRule {
    std::string material;
    TileOptions tile;
};

enum class EmbossMethod : std::uint8_t { normals, displace };

struct EmbossOptions {
    std::vector<EmbossRule> rules = {};  ///< each name once; none: no relief
    int detail = 4;                      ///< pieces along an edge of a voxel face
    EmbossMethod method = EmbossMethod::normals;
};

enum class OutputFormat : std::uint8_t { glb, obj, vox, nrrd };
enum class Parts : std::uint8_t { exterior, interfaces };
enum class Colors : std::uint8_t { voxel, label, none };
enum class Shading : std::uint8_t { smooth, crease, flat };
enum class Compression : std::uint8_t { draco, none };
enum class Pivot : std::uint8_t { bottom, center, corner, world };
enum class UpAxis : std::uint8_t { y, z };

/// The largest number in a scale, after it is reduced.
inline constexpr int kMaxScale = 16;

/// Voxels of the output for one of the input along each axis: up / down, without common factor.
struct Scale {
    int up = 1;
    int down = 1;
    bool operator==(const Scale&) const = default;
};

struct OutputOptions {
    OutputFormat format = OutputFormat::glb;
    Scale scale = {};  ///< of the voxel outputs, `vox` and `nrrd`
    Parts parts = Parts::exterior;
    Colors colors = Colors::voxel;
    Shading shading = Shading::crease;
    Compression compression = Compression::draco;
    std::optional<int> dracoPositionBits;  ///< automatic: a step of at most 0.01 voxel
    int dracoSpeed = 5;                    ///< 0 smallest .. 10 fastest
    double voxelSize = 0.1;                ///< metres
    Pivot pivot = Pivot::bottom;
    UpAxis up = UpAxis::y;
};

/// Whether the result is voxels again, not a mesh.
[[nodiscard]] constexpr bool isVoxels(OutputFormat format) {
    return format == OutputFormat::vox || format == OutputFormat::nrrd;
}

struct ConversionOptions {
    InputOptions input = {};
    Preset preset = Preset::studio;
    MethodOptions method = {};  ///< those of `preset`, with what was given beside it
    EmbossOptions emboss = {};
    OutputOptions output = {};
};

}  // namespace rivage::core
