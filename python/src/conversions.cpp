// SPDX-License-Identifier: MIT
#include "python/src/conversions.h"

#include <cmath>

#include <Eigen/Geometry>

#include <kibori/haptics/force.h>

namespace kibori::python {
namespace {

// Tolerance of a quaternion's length, for numbers with few digits.
constexpr double kUnit = 1e-2;

Pose pose_of_numbers(const double* row, py::ssize_t columns, const std::string& which) {
  for (py::ssize_t i = 0; i < columns; i++)
    if (!std::isfinite(row[i])) throw Failure(which + " has a number that is not finite");
  Pose pose;
  pose.tip = Vec3(row[0], row[1], row[2]);
  if (columns == 7) {
    const Eigen::Quaterniond turn(row[6], row[3], row[4], row[5]);
    if (!(std::abs(turn.norm() - 1) < kUnit))
      throw Failure(which + " has a quaternion (x, y, z, w) whose length is not 1");
    pose.frame = turn.normalized().toRotationMatrix();
  }
  return pose;
}

}  // namespace

std::vector<Pose> poses_of(const Doubles& rows) {
  if (rows.ndim() != 2 || (rows.shape(1) != 3 && rows.shape(1) != 7))
    throw py::value_error(
        "a path must be an array of N rows: x, y, z, or x, y, z and a quaternion x, y, z, w");
  std::vector<Pose> poses;
  poses.reserve(static_cast<size_t>(rows.shape(0)));
  for (py::ssize_t i = 0; i < rows.shape(0); i++)
    poses.push_back(pose_of_numbers(rows.data(i, 0), rows.shape(1),
                                    "row " + std::to_string(i) + " of the path"));
  return poses;
}

Pose pose_of(const Doubles& row) {
  if (row.ndim() != 1 || (row.shape(0) != 3 && row.shape(0) != 7))
    throw py::value_error("a pose must be x, y, z, or x, y, z and a quaternion x, y, z, w");
  return pose_of_numbers(row.data(0), row.shape(0), "the pose");
}

double share_of(const std::string& powered) {
  if (powered.empty()) return 1;
  if (powered == "motor") return kPoweredShare;
  if (powered == "press") return kPressShare;
  throw Failure("powered must be \"motor\", \"press\" or \"\"");
}

}  // namespace kibori::python
