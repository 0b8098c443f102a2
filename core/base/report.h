#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/run_context.h"

namespace rivage::core {

struct InputReport {
    std::string format;                      ///< e.g. "vox 200"
    std::array<int, 3> dims{};               ///< of the merged grid, voxels
    std::array<double, 3> spacing{1, 1, 1};  ///< sides of a voxel; the shortest is 1
    std::uint64_t voxels = 0;                ///< not empty, after merging
    std::uint64_t models = 0;
    std::uint64_t instances = 0;  ///< merged ones
    std::uint64_t materials = 0;  ///< used ones
    struct LabelInfo {
        std::string name;
        std::uint64_t voxels = 0;
    };
    std::vector<LabelInfo> labels;  ///< label 1 first
};

struct SurfaceReport {
    std::uint64_t pointels = 0;
    std::uint64_t surfels = 0;
    std::uint64_t linels = 0;
    std::uint64_t junctionLinels = 0;
    std::uint64_t junctionPointels = 0;
    /// What `normals=auto` chose, as means over an interface.
    struct NormalChoice {
        double noise = 0;   ///< 0 clean .. 1 noisy: share of the estimate for noisy labels
        double sharp = 0;   ///< share of the estimate for creases, 0 .. 1
        double radius = 0;  ///< of the windows on smooth parts, voxels
    };
    std::uint64_t splitPointels = 0;  ///< that became several vertices
    struct InterfaceInfo {
        std::string inner;
        std::string outer;
        std::uint64_t surfels = 0;
        std::optional<NormalChoice> normals;
    };
    std::vector<InterfaceInfo> interfaces;
    std::optional<std::uint64_t> featureLinels;  ///< found by `normals=piecewise-smooth`
};

/// The energy by term, METHOD.md section 2.2.
struct EnergyReport {
    double data = 0;
    double alignment = 0;
    double fairness = 0;
    [[nodiscard]] double total() const { return data + alignment + fairness; }
};

struct SolveReport {
    std::string solver;
    int iterations = 0;
    double residual = 0;  ///< relative, of the linear system or of the KKT conditions
    EnergyReport before;
    EnergyReport after;
    double displacementRms = 0;        ///< shortest sides of a voxel, Euclidean
    double displacementMax = 0;        ///< largest along an axis, sides of a voxel along that axis
    std::uint64_t invertedBefore = 0;  ///< faces, before untangling
    std::uint64_t invertedAfter = 0;
    std::uint64_t crossingBefore = 0;  ///< pairs of faces at split pointels, before untangling
    std::uint64_t crossingAfter = 0;
};

/// What the relief of height tiles did to the surface.
struct EmbossReport {
    int detail = 0;
    std::string method;
    std::uint64_t surfels = 0;  ///< pieces of surfels
    std::uint64_t pointels = 0;
    struct TileInfo {
        std::string material;  ///< as the caller named it
        std::string tile;
        std::uint64_t surfels = 0;  ///< whole ones, before they were cut
    };
    std::vector<TileInfo> tiles;
    int iterations = 0;  ///< of the solver; none for `displace`
    double residual = 0;
    double reliefMax = 0;  ///< largest way from the surface without relief along an axis, voxels
    double reliefRms = 0;  ///< Euclidean, over the pointels of faces with tiles
    /// Largest distance along an axis of a piece's corner from its own place on the voxel face,
    /// sides of a voxel along that axis.
    double displacementMax = 0;
    std::uint64_t invertedAfter = 0;  ///< pieces
    std::uint64_t crossingAfter = 0;  ///< pairs of pieces at split pointels
};

struct OutputReport {
    std::string mediaType;
    std::uint64_t vertices = 0;  ///< of a mesh, as are triangles and parts
    std::uint64_t triangles = 0;
    std::uint64_t parts = 0;
    std::optional<std::uint64_t> bytes;  ///< unknown inside the artifact itself
    /// One entry a label, label 1 first: every edge of its boundary has an even number of faces.
    std::vector<bool> closed;
    /// As above: it is not closed, and all edges with an odd number lie on the border of the grid.
    std::vector<bool> openAtBorder;
};

/// The model as voxels at another resolution.
struct VoxelReport {
    std::array<int, 3> dims{};
    std::uint64_t voxels = 0;       ///< not empty
    std::string scale;              ///< "3", "1/2"
    std::uint64_t folded = 0;       ///< samples where the surface is folded over: a vote decided
    std::uint64_t samplesEach = 1;  ///< samples that decide on one voxel
    std::uint64_t rescued = 0;      ///< voxels of thin parts that the majority would have lost
    std::uint64_t colors = 0;       ///< palette entries in use, or labels
    std::uint64_t models = 1;       ///< tiles of a .vox
    /// Colours that had to be joined: how far voxels are from theirs, OKLab distance.
    struct PaletteError {
        double max = 0;
        double mean = 0;
    };
    std::optional<PaletteError> paletteError;
    struct Topology {
        std::uint64_t components = 0;  ///< joined by faces, edges or corners of voxels
        std::uint64_t tunnels = 0;
        std::uint64_t cavities = 0;
    };
    struct LabelTopology {
        Topology before;  ///< of the input
        Topology after;
    };
    std::vector<LabelTopology> topology;  ///< label 1 first; of coarser results only
};

struct ConversionReport {
    InputReport input;
    SurfaceReport surface;
    nlohmann::ordered_json options;  ///< the options in force, filled in by the caller
    SolveReport solve;
    std::optional<EmbossReport> emboss;  ///< none without relief
    OutputReport output;
    std::optional<VoxelReport> voxels;  ///< of the voxel outputs only
    /// Wall time by stage; measured by the caller, so that core reads no clock; never in the
    /// artifact, whose bytes must not depend on time.
    std::optional<std::array<double, kStageCount>> milliseconds;
    std::vector<std::string> warnings;
};

/// How sure a claim about a result is.
enum class Evidence : std::uint8_t {
    none,     ///< it may not hold
    checked,  ///< every place where it could fail was looked at in this result
    proved,   ///< it follows from the largest displacement along an axis of any vertex
};

/// What holds for the positions of a result, before they are rounded for a file.
/// @source METHOD.md 7.1
struct Guarantees {
    /// No face passes a voxel centre: each keeps its label. Below 0.5 voxels.
    Evidence separation = Evidence::none;
    /// Faces without a common vertex do not meet. Below 0.5 voxels only faces at the copies of a
    /// split pointel could, and those are looked at.
    Evidence noIntersection = Evidence::none;
    /// Below 0.25 voxels the triangles of each face, however it is cut, keep their orientation seen
    /// along the axis of its lattice face; checked: no two corner normals of a face are more than
    /// a right angle apart, and no face has collapsed.
    Evidence noInversion = Evidence::none;
    /// Every edge has an even number of faces of each label.
    Evidence closed = Evidence::none;
};
[[nodiscard]] Guarantees guaranteesOf(const ConversionReport& report);

/// The report as users see it (API.md section 3).
[[nodiscard]] nlohmann::ordered_json toJson(const ConversionReport& report);

/// What `POST /v1/inspect` answers: the input and the surface, nothing solved.
struct Inspection {
    InputReport input;
    std::uint64_t surfels = 0;
    std::uint64_t pointels = 0;
    std::uint64_t predictedMemory = 0;  ///< bytes
    struct PaletteEntry {
        std::uint32_t source = 0;  ///< palette entry or stored value
        std::string color;         ///< "#rrggbbaa", sRGB
        std::string label;
        std::string kind;  ///< material class
        std::string name;
    };
    std::vector<PaletteEntry> palette;
    std::vector<std::string> warnings;
};
[[nodiscard]] nlohmann::ordered_json toJson(const Inspection& inspection);

}  // namespace rivage::core
