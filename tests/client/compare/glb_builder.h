#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/compare/surface.h"
#include "proto/json.h"

namespace rivage::client::test {

/// Positions and triangles to be written or measured.
struct Shape {
    std::vector<Eigen::Vector3f> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Eigen::Vector3f> colors;  ///< linear; empty for none
};

/// A square from 0 to `size` in x and y at height z, of n*n*2 triangles, its normal up.
Shape plane(float size, int n, float z);
/// The cube from `low` to `high` in all three, its normals outwards, 12 triangles.
Shape cube(float low, float high);
/// A ball around `center` of n rings with 2n segments, its normals outwards.
Shape ball(const Eigen::Vector3f& center, float radius, int n);
/// The faces turned round.
Shape turned(Shape shape);
Shape shifted(Shape shape, const Eigen::Vector3f& by);
Shape painted(Shape shape, const Eigen::Vector3f& color);

/// One part a shape, named "part 1" and so on, in the order given.
Surface surfaceOf(const std::vector<Shape>& shapes);

/// A container around a JSON text and bytes, lengths as they are.
std::string container(const std::string& json, const std::string& binary);

/// The two halves of a GLB, so that a test can spoil one of them.
struct GlbSource {
    proto::Json json;
    std::string binary;
    [[nodiscard]] std::string bytes() const { return container(json.dump(), binary); }
};

/// Shapes as a GLB, one node a shape, as plain buffers.
/// @param report  goes to asset.extras.rivage; null for none
GlbSource plainGlb(const std::vector<Shape>& shapes, const proto::Json& report = {});
/// The same with a Draco stream, positions rounded to `bits` of the largest extent.
GlbSource dracoGlb(const std::vector<Shape>& shapes, int bits);

/// Checks that the bytes of a file are refused, and that the words say something of why.
void refuse(const std::string& bytes, const char* why);

}  // namespace rivage::client::test
