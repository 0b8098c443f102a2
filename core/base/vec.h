#pragma once

#include <Eigen/Core>

namespace rivage::core {

using Vec3i = Eigen::Vector3i;  ///< voxel or pointel coordinates
using Vec3d = Eigen::Vector3d;  ///< positions in voxel units, or directions
using Mat3i = Eigen::Matrix3i;
using Mat3d = Eigen::Matrix3d;

}  // namespace rivage::core
