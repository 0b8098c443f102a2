#include <doctest/doctest.h>

#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "core/solve/minimize.h"
#include "tests/support/grids.h"
#include "tests/support/npy.h"

// Compares with minimizers that another program solved exactly, on digital surfaces and normals of
// yet another: set RIVAGE_REFERENCE to the folder that holds sphere_r20, goursat_h1 and cat10.

using namespace rivage::core;
using namespace rivage::test;

namespace {

const EnergyOptions kPaper = presetOptions(Preset::paper).energy;

using Key = std::tuple<int, int, int>;
using SurfelKey = std::pair<Key, Key>;

Key key(const Vec3i& p) { return {p.x(), p.y(), p.z()}; }

VoxelGrid readGrid(const std::filesystem::path& folder, const Vec3i& size) {
    const auto values = readNpyFile<std::uint8_t>(folder / "grid.npy");
    return makeGrid(size, 1, [&](const Vec3i& v) {
        return values[static_cast<std::size_t>((v.z() * size.y() + v.y()) * size.x() + v.x())];
    });
}

/// The stored normals in the order of our surfels.
NormalField readNormals(const std::filesystem::path& folder, const std::string& name,
                        const DigitalSurface& surface) {
    const auto surfels = readNpyFile<std::int32_t>(folder / "surfels.npy");
    const auto normals = readNpyFile<double>(folder / ("normals_" + name + ".npy"));
    std::map<SurfelKey, Vec3d> byVoxels;
    for (std::size_t f = 0; f * 10 < surfels.size(); ++f) {
        const std::int32_t* row = &surfels[f * 10];
        byVoxels[{{row[0], row[1], row[2]}, {row[3], row[4], row[5]}}] =
            Vec3d(normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]);
    }
    NormalField field(surface.surfelCount());
    for (std::size_t f = 0; f < surface.surfelCount(); ++f) {
        const SurfelId s{static_cast<std::uint32_t>(f)};
        field[s] = byVoxels.at({key(surface.innerVoxel(s)), key(surface.outerVoxel(s))});
    }
    return field;
}

double maxDifference(const std::filesystem::path& folder, const std::string& name,
                     const DigitalSurface& surface, const PointelVectors& positions) {
    const auto pointels = readNpyFile<std::int32_t>(folder / "pointels.npy");
    const auto stored = readNpyFile<double>(folder / ("pstar_" + name + ".npy"));
    std::map<Key, Vec3d> byPointel;
    for (std::size_t i = 0; i < pointels.size(); i += 3)
        byPointel[{pointels[i], pointels[i + 1], pointels[i + 2]}] =
            Vec3d(stored[i], stored[i + 1], stored[i + 2]);
    REQUIRE(byPointel.size() == surface.pointelCount());
    double worst = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const PointelId p{static_cast<std::uint32_t>(i)};
        const Vec3d off = positions[p] - byPointel.at(key(surface.pointels[p]));
        worst = std::max(worst, off.cwiseAbs().maxCoeff());
    }
    return worst;
}

}  // namespace

TEST_SUITE("core/solve") {
    TEST_CASE("differential: the exact minimizers of an independent program" *
              doctest::skip(std::getenv("RIVAGE_REFERENCE") == nullptr)) {
        const std::filesystem::path root = std::getenv("RIVAGE_REFERENCE");
        for (const char* shape : {"sphere_r20", "goursat_h1", "cat10"}) {
            CAPTURE(shape);
            std::ifstream metaFile(root / shape / "meta.json");
            const auto meta = nlohmann::json::parse(metaFile);
            std::ifstream gridFile(root / shape / "grid.npy");
            std::string header(200, ' ');
            gridFile.read(header.data(), 200);
            Vec3i size;  // the header says (nz, ny, nx)
            std::sscanf(header.c_str() + header.find('(', 10), "(%d, %d, %d", &size.z(), &size.y(),
                        &size.x());
            const auto surface = extractSurface(readGrid(root / shape, size), {});
            REQUIRE(surface);
            REQUIRE(surface->surfelCount() == meta.at("surfels"));
            for (const std::string name : {"trivial", "ii"}) {
                CAPTURE(name);
                const Energy energy(*surface, readNormals(root / shape, name, *surface),
                                    EnergyWeights::uniform(*surface, kPaper), kPaper, 1);
                const auto solution =
                    minimize(energy, {.displacementLimit = std::nullopt, .tolerance = 1e-10}, {});
                REQUIRE(solution);
                const double before = energy.value(energy.restPositions()).total();
                const double after = energy.value(solution->positions).total();
                const double off = maxDifference(root / shape, name, *surface, solution->positions);
                MESSAGE(shape << " " << name << ": E(p) " << before << ", E(P*) " << after
                              << ", largest difference of a coordinate " << off << " voxel");
                CHECK(before ==
                      doctest::Approx(meta[name]["E_initial"].get<double>()).epsilon(1e-9));
                CHECK(after == doctest::Approx(meta[name]["E_pstar"].get<double>()).epsilon(1e-8));
                CHECK(off < 1e-6);
            }
        }
    }
}
