// SPDX-License-Identifier: MIT
// Vectors, boxes and poses. Units are mm unless stated. lattice.h has the types in lattice units.
#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace kibori {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Index3 = Eigen::Array3i;

// Axis-aligned box. Empty if min > max on some axis.
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

// The position of a tool: its tip (origin of the tool frame) and its frame. frame.col(2) points
// from the tip into the tool.
struct Pose {
  Vec3 tip = Vec3::Zero();
  Mat3 frame = Mat3::Identity();

  Vec3 axis() const { return frame.col(2); }
  Vec3 to_world(const Vec3& in_tool) const { return tip + frame * in_tool; }
  // Converts a pose from this frame to the world, and back.
  Pose to_world(const Pose& in_this) const {
    return {to_world(in_this.tip), frame * in_this.frame};
  }
  Pose from_world(const Pose& in_world) const {
    return {frame.transpose() * (in_world.tip - tip), frame.transpose() * in_world.frame};
  }
};

// A frame whose third column is `axis` (any length > 0). The first column is turned about it by
// roll_rad from a fixed reference: the world x axis, or y if x is nearly parallel.
Mat3 frame_from_axis(const Vec3& axis, double roll_rad = 0);

// Rotation vector that takes direction `from` to `to`, both unit, along the shortest arc. Its
// direction is the axis, and its length the angle [rad]. It is zero for opposite directions, which
// the caller must reject.
Vec3 shortest_turn(const Vec3& from, const Vec3& to);

// Rotation matrix of a rotation vector [rad] (Rodrigues).
Mat3 rotation(const Vec3& rotation_vector);

// The shortest rotation vector that takes frame `from` to frame `to`.
Vec3 rotation_between(const Mat3& from, const Mat3& to);

}  // namespace kibori
