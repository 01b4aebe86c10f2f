// SPDX-License-Identifier: MIT
// Random places on random lattices, and statistics of errors, for tests of volumes and forces.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/tool.h>

#include "tests/support.h"

namespace kibori::test {

// Orientation of a shape relative to the lattice's axes.
enum class Lie { on_axes, near_axes, oblique };
inline const char* name_of_lie(Lie lie) {
  return lie == Lie::on_axes ? "on axes" : lie == Lie::near_axes ? "2 degrees off" : "oblique";
}
inline constexpr Lie kLies[] = {Lie::on_axes, Lie::near_axes, Lie::oblique};

// One of the 24 frames whose axes are those of the lattice.
inline Mat3 random_axes(Random& random) {
  const int first = random.integer(0, 2), second = (first + random.integer(1, 2)) % 3;
  Mat3 frame;
  frame.col(0) = Vec3::Unit(first) * (random.integer(0, 1) ? 1 : -1);
  frame.col(1) = Vec3::Unit(second) * (random.integer(0, 1) ? 1 : -1);
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame;
}

inline Mat3 random_frame(Random& random, Lie lie) {
  if (lie == Lie::on_axes) return random_axes(random);
  if (lie == Lie::near_axes) {
    constexpr double kTwoDegrees = 0.0349;
    return Eigen::AngleAxisd(kTwoDegrees, random.direction()).toRotationMatrix() *
           random_axes(random);
  }
  Mat3 frame;
  frame.col(2) = random.direction();
  do frame.col(0) = frame.col(2).cross(random.direction());
  while (frame.col(0).norm() < 0.1);
  frame.col(0).normalize();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

// A lattice that contains a box of `size` about `centre`, in any orientation of the box. The
// lattice's offset and its number of nodes are random.
inline Lattice random_lattice(Random& random, const Vec3& centre, const Vec3& size, double pitch) {
  Lattice lattice;
  lattice.pitch_mm = pitch;
  for (int i = 0; i < 3; i++) {
    lattice.nodes[i] = static_cast<int>(size.norm() / pitch) + random.integer(3, 20);
    lattice.origin_mm[i] = centre[i] - 0.5 * pitch * (lattice.nodes[i] + random.uniform(-1, 1));
  }
  return lattice;
}

// A box in any frame. The frame's origin is the box's centre.
struct PlacedBox {
  Vec3 centre, size;
  Mat3 frame;

  Vec3 at(const Vec3& in_box) const { return centre + frame * in_box; }
  Tool tool() const { return BoxTool{size}; }
  // Pose of a BoxTool of this size. Its tip is the middle of its lower face.
  Pose pose() const { return {at(Vec3(0, 0, -0.5 * size.z())), frame}; }
  double volume() const { return size.prod(); }
};

// Adds the body of a tool at rest. Returns the added volume [mm^3].
inline double add_tool(TriDexel& model, const Tool& tool, const Pose& pose, uint8_t material = 0) {
  Removed added;
  const SweptTool solid(tool, pose, Vec3::Zero(), model.lattice());
  deposit(model, solid.solid(), material, {}, added);
  return added.volume() * std::pow(model.lattice().pitch_mm, 3);
}
inline double cut_tool(TriDexel& model, const Tool& tool, const Pose& pose,
                       const Vec3& motion = Vec3::Zero()) {
  Removed removed;
  const SweptTool solid(tool, pose, motion, model.lattice());
  cut(model, solid.solid(), {}, removed);
  return removed.volume() * std::pow(model.lattice().pitch_mm, 3);
}

// Mean, root mean square and largest absolute value of errors.
class Errors {
 public:
  void add(double error) {
    count_++;
    sum_ += error;
    squares_ += error * error;
    largest_ = std::max(largest_, std::abs(error));
  }
  int count() const { return count_; }
  double mean() const { return sum_ / count_; }
  double rms() const { return std::sqrt(squares_ / count_); }
  double deviation() const { return std::sqrt(std::max(0.0, squares_ / count_ - mean() * mean())); }
  double largest() const { return largest_; }
  // Bound for the absolute value of the mean: `aim`, and four standard deviations of the mean.
  double mean_bound(double aim) const { return aim + 4 * deviation() / std::sqrt(count_); }

 private:
  int count_ = 0;
  double sum_ = 0, squares_ = 0, largest_ = 0;
};

// Factor on the bound of a root mean square of `count` errors, because this value varies from run
// to run. It varies much, because a few thin cuts have most of the error.
inline double scatter(int count) { return 1 + 4 / std::sqrt(count); }

// Area of the segment of a circle of radius r that is `depth` high.
inline double segment_area(double r, double depth) {
  return r * r * std::acos(1 - depth / r) - (r - depth) * std::sqrt(depth * (2 * r - depth));
}

// Random tetrahedron whose lowest vertex is the tip.
inline MeshTool random_tetrahedron(Random& random, double size) {
  auto mesh = std::make_shared<TriangleMesh>();
  const auto near = [&](double x, double y, double z) {
    return Vec3(size * (Vec3(x, y, z) + random.in_box(-0.15, 0.15)));
  };
  mesh->vertices = {Vec3::Zero(), near(1, 0, 1), near(-0.5, 0.9, 1), near(-0.5, -0.9, 1.2)};
  mesh->triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}};
  return {mesh};
}

// Area [mm^2] of the section that a tetrahedron cuts while it moves along its x axis, up to the
// height `depth`. The section is the tetrahedron's projection along x. At one height it spans the
// lines between all pairs of vertices.
inline double shadow_area(const MeshTool& tool, double depth) {
  constexpr int kSlices = 4000;
  double area = 0;
  for (int i = 0; i < kSlices; i++) {
    const double z = depth * (i + 0.5) / kSlices;
    double low = 1e30, high = -1e30;
    for (const Vec3& a : tool.mesh->vertices)
      for (const Vec3& b : tool.mesh->vertices) {
        if (!(a.z() <= z && z < b.z())) continue;
        const double y = a.y() + (b.y() - a.y()) * (z - a.z()) / (b.z() - a.z());
        low = std::min(low, y);
        high = std::max(high, y);
      }
    if (high > low) area += (high - low) * depth / kSlices;
  }
  return area;
}

// A mesh with a flat bottom, wider at its top: a frustum.
inline MeshTool random_frustum(Random& random, const Vec3& size) {
  auto mesh = std::make_shared<TriangleMesh>();
  const double wider = random.uniform(1.05, 1.3);
  for (int i = 0; i < 8; i++) {
    const double scale = i & 4 ? wider : 1;
    mesh->vertices.push_back({(i & 1 ? 0.5 : -0.5) * scale * size.x(),
                              (i & 2 ? 0.5 : -0.5) * scale * size.y(), i & 4 ? size.z() : 0});
  }
  mesh->triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                     {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return {mesh};
}

// A tool, and the closed form of what it cuts while it moves along its x axis.
struct Cutter {
  Tool tool;
  double section;  // [mm^2]; its tip is `depth` below the face
  double width;    // of the tool, or more
};

enum class Kind { ball, cone, gouge, flat, box, frustum, tetrahedron };
inline constexpr Kind kKinds[] = {Kind::ball, Kind::cone,    Kind::gouge,      Kind::flat,
                                  Kind::box,  Kind::frustum, Kind::tetrahedron};
inline constexpr int kKindCount = 7;
inline const char* name_of_kind(Kind kind) {
  constexpr const char* kNames[] = {"ball", "cone",    "gouge",      "flat",
                                    "box",  "frustum", "tetrahedron"};
  return kNames[static_cast<int>(kind)];
}
// Approximate ratio of a cut's depth to its mean thickness.
inline double depth_of(Kind kind) {
  constexpr double kFactor[] = {1.5, 2, 1.5, 1, 1, 1, 2};
  return kFactor[static_cast<int>(kind)];
}

// A random tool that is higher than `depth`. Its cut is at least `width` wide. A tetrahedron's cut
// may be narrower.
inline Cutter random_cutter(Random& random, Kind kind, double pitch, double depth,
                            double width = 0) {
  const double radius = pitch * random.uniform(6, 12) + 0.6 * depth, length = 2 * depth + 9 * pitch;
  switch (kind) {
    case Kind::ball:
      return {BallTool{radius}, segment_area(radius, depth), 2 * radius};
    case Kind::cone: {
      constexpr double kDegree = std::numbers::pi / 180;
      const double narrow = std::max(60.0, 2 / kDegree * std::atan(width / 2 / depth));
      const double angle = random.uniform(narrow, std::max(140.0, narrow + 3));
      const double tan = std::tan(angle / 2 * kDegree);
      return {Cone{angle, depth * tan + 3 * pitch, length}, depth * depth * tan,
              2 * depth * tan + 6 * pitch};
    }
    case Kind::gouge: {
      // Sweep 9: half a circle.
      const double r = std::max(radius, 1.1 * depth);
      return {Gouge{9, 2 * r, 4 * pitch, length + r}, segment_area(r, depth), 2 * r};
    }
    case Kind::flat:
      return {Flat{radius, length}, 2 * radius * depth, 2 * radius};
    case Kind::box:
      return {BoxTool{Vec3(radius, 1.5 * radius, length)}, 1.5 * radius * depth, 1.5 * radius};
    case Kind::frustum: {
      const MeshTool tool = random_frustum(random, Vec3(radius, 1.4 * radius, length));
      return {tool, shadow_area(tool, depth), 1.9 * radius};
    }
    case Kind::tetrahedron: {
      const MeshTool tool = random_tetrahedron(random, 1.3 * depth + 6 * pitch);
      return {tool, shadow_area(tool, depth), 3 * depth + 14 * pitch};
    }
  }
  return {};
}

}  // namespace kibori::test
