#pragma once

#include <cstdint>
#include <vector>

#include "core/voxelize/moved_surface.h"
#include "core/voxelize/sample_lattice.h"

namespace rivage::core {

/// Columns of samples along z that are scanned together: those over one column of bricks.
struct ColumnBlock {
    static constexpr int kSide = 16;
    static constexpr int kColumns = kSide * kSide;

    int x = 0;  ///< first sample along x, y
    int y = 0;
};

/// A column of samples passes a face.
struct Crossing {
    std::int32_t column = 0;  ///< in the block, x fastest
    std::int32_t sample = 0;  ///< the first sample above the face; 0 also for faces below all
    Label from = Label{0};    ///< below the face
    Label to = Label{0};      ///< above it
};

/// The samples along x and y that a face may cover, ends included; empty if one is not ordered.
struct SampleRange {
    int xBegin, xLast, yBegin, yLast;
};
[[nodiscard]] SampleRange samplesUnder(const MovedSurface& moved, SurfelId s,
                                       const SampleLattice& lattice);

/// Appends where the columns of a block pass a face, cut along the diagonal of `mesh/diagonal.h`.
/// Exact: coordinates are whole numbers, and each column stands off every edge by an infinitesimal
/// step (e, e^2), so of two triangles that share an edge a column passes exactly one.
/// @source  METHOD.md 5; the step is the top-left rule of rasterizers
void appendCrossings(const MovedSurface& moved, SurfelId s, const SampleLattice& lattice,
                     const ColumnBlock& block, std::vector<Crossing>& crossings);

}  // namespace rivage::core
