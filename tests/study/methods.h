#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/mesh.h"
#include "tests/support/regularized.h"

/// The methods of the study, and one run of one of them.
namespace rivage::study {

enum class Kind : std::uint8_t {
    raw,             ///< the digital surface itself
    marchingCubes,   ///< mid-point
    dualContouring,  ///< normals `auto`
    dualContouringInCell,
    surfaceNets,    ///< no iteration
    surfaceNets16,  ///< 16 iterations
    energy          ///< ours, with the options of the method
};

struct Method {
    std::string name;
    Kind kind = Kind::energy;
    MethodOptions options = {};  ///< of `Kind::energy`
    [[nodiscard]] bool isDual() const { return kind != Kind::marchingCubes; }
};

/// Every method of the study by its name; the presets have theirs. "paper, auto normals" is the
/// paper's energy with the normals that `studio` and dual contouring get.
[[nodiscard]] const Method& method(const std::string& name);

/// What the input of all methods is disturbed by.
struct Disturbance {
    double normalTilt = 0;     ///< degrees, deviation of a Gaussian
    double positionNoise = 0;  ///< voxels, half the width of a uniform distribution
    std::uint32_t seed = 1;
};

struct Outcome {
    StudyMesh mesh;
    /// Of methods whose faces are surfels, for measures that need to know.
    DigitalSurface surface;
    PointelVectors positions;
    NormalField normals;      ///< empty where the method needs none
    double milliseconds = 0;  ///< of this thread, normals and positions together
};

/// Runs methods on one grid; the surface and each field of normals is computed once.
class Bench {
public:
    Bench(const VoxelGrid& grid, const Disturbance& disturbance)
        : grid_(grid), disturbance_(disturbance) {}

    [[nodiscard]] Outcome run(const Method& method);

private:
    struct Field {
        NormalOptions options;
        NormalField normals;
        double milliseconds;
    };

    const DigitalSurface& whole();
    const test::Regularized& linked(bool split);
    const Field& field(const NormalOptions& options);
    void runEnergy(const MethodOptions& options, Outcome& outcome);
    void runDual(Kind kind, Outcome& outcome);
    [[nodiscard]] PointelVectors movedRest(const DigitalSurface& surface) const;

    const VoxelGrid& grid_;
    Disturbance disturbance_;
    std::optional<test::Regularized> linked_[2];
    std::vector<std::unique_ptr<Field>> fields_;
};

}  // namespace rivage::study
