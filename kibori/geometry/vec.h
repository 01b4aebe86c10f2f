// SPDX-License-Identifier: MIT
// Vectors, boxes and poses. Units are mm unless stated otherwise. lattice.h has the types for
// lattice units.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kibori {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Index3 = Eigen::Array3i;

// An axis-aligned box. It is empty if min > max on some axis.
struct Box {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return !(min.array() <= max.array()).all(); }
  void include(const Vec3& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  void include(const Box& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
  Box grown(double by) const { return {min.array() - by, max.array() + by}; }
  Vec3 size() const { return max - min; }
  Vec3 centre() const { return 0.5 * (min + max); }
};

// The pose of a tool or a body. `tip` is the origin of its frame, and the columns of `frame` are
// the frame's axes. For a tool, the third column points from the tip into the tool.
struct Pose {
  Vec3 tip = Vec3::Zero();
  Mat3 frame = Mat3::Identity();

  Vec3 axis() const { return frame.col(2); }
  Vec3 to_world(const Vec3& in_tool) const { return tip + frame * in_tool; }
  // Converts a pose from this frame to the world (to_world), and from the world to this frame
  // (from_world).
  Pose to_world(const Pose& in_this) const {
    return {to_world(in_this.tip), frame * in_this.frame};
  }
  Pose from_world(const Pose& in_world) const {
    return {frame.transpose() * (in_world.tip - tip), frame.transpose() * in_world.frame};
  }
};

// Returns a frame whose third column points along `axis` (any length > 0). With roll_rad = 0, the
// first column is as near as possible to the world's x axis. If x is nearly parallel to `axis`, y
// replaces it. roll_rad turns the first column about `axis`.
Mat3 frame_from_axis(const Vec3& axis, double roll_rad = 0);

// Returns the rotation vector that turns the unit vector `from` to the unit vector `to` by the
// shortest arc. A rotation vector points along the rotation's axis, and its length is the angle
// [rad]. For opposite vectors, the result is zero; the caller must reject them.
Vec3 shortest_turn(const Vec3& from, const Vec3& to);

// Returns the matrix of a rotation vector [rad] (formula of Rodrigues).
Mat3 rotation(const Vec3& rotation_vector);

// Returns the shortest rotation vector that turns frame `from` to frame `to`.
Vec3 rotation_between(const Mat3& from, const Mat3& to);

}  // namespace kibori
