#pragma once

#include <vector>

#include "core/base/ids.h"
#include "core/base/vec.h"

/// Four floats that are computed with as one. Plain vector extensions of the compiler, which every
/// processor of the architecture has, so that the bits are the same everywhere.
namespace rivage::core {

using Lanes = float __attribute__((vector_size(16)));

/// A 3-vector of one pointel in float: x, y, z and a fourth lane that stays 0 in vectors.
struct Float4 {
    Lanes lanes;
};

/// A symmetric 3x3 matrix: the diagonal (xx, yy, zz) and beside it (xy, yz, zx). The fourth lanes
/// are free for the owner; they must be finite.
struct Symmetric3 {
    Lanes diagonal;
    Lanes beside;
};

/// Vectors of all pointels in float, for the inner loops of the solvers.
using FloatVectors = IdVector<PointelId, Float4>;

#define RIVAGE_INLINE inline __attribute__((always_inline))

/// (y, z, x, w)
RIVAGE_INLINE Lanes turned(const Lanes& v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); }
/// (z, x, y, w)
RIVAGE_INLINE Lanes turnedTwice(const Lanes& v) {
    return __builtin_shufflevector(v, v, 2, 0, 1, 3);
}
RIVAGE_INLINE Lanes product(const Symmetric3& m, const Lanes& v) {
    return m.diagonal * v + m.beside * turned(v) + turnedTwice(m.beside) * turnedTwice(v);
}
RIVAGE_INLINE Lanes lanesOf(const Vec3d& v) {
    return Lanes{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0};
}
RIVAGE_INLINE Vec3d vectorOf(const Lanes& v) { return {v[0], v[1], v[2]}; }

/// True if any of the first three lanes of a comparison holds.
template <typename Comparison>
RIVAGE_INLINE bool anyLane(const Comparison& holds) {
    return (holds[0] | holds[1] | holds[2]) != 0;
}

/// m += scale * v v^T
RIVAGE_INLINE void addSquare(Symmetric3& m, const Lanes& v, float scale) {
    m.diagonal += scale * v * v;
    m.beside += scale * v * turned(v);
}
/// The inverse of a positive definite matrix; its fourth lanes are 0.
[[nodiscard]] Symmetric3 inverseOf(const Symmetric3& m);

}  // namespace rivage::core
