// SPDX-License-Identifier: MIT
#include <kibori/formats/polygons.h>

#include <array>
#include <cstddef>
#include <utility>

namespace kibori {
namespace {

// Limits of the number of tests of a corner against an ear. A face first uses kComparisonsPerCorner
// for each of its corners, which is enough for any face with up to 50 corners. After that it uses
// kComparisons, which all faces share and which takes some seconds. With larger values, a malicious
// file of some megabytes would take minutes.
constexpr size_t kComparisons = 1'000'000'000, kComparisonsPerCorner = 1000;

using Point = std::array<double, 2>;

// Twice the signed area of a triangle.
double area(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Cuts ears off a polygon that turns counterclockwise.
//
//        d-----c        b is an ear if the corner turns left and no other
//        |    /|        corner is inside the triangle a b c.
//        |   / |
//        e  a--b
class EarCutter {
 public:
  // `budget`: the number of tests that all faces together may still use.
  EarCutter(const std::vector<Point>& points, size_t& budget)
      : points_(points),
        budget_(budget),
        own_(kComparisonsPerCorner * points.size()),
        before_(points.size()),
        after_(points.size()) {
    for (size_t i = 0; i < points.size(); i++) {
      before_[i] = (i + points.size() - 1) % points.size();
      after_[i] = (i + 1) % points.size();
    }
  }

  // Returns the corners of each triangle, as indices of points. The number of triangles is the
  // number of points minus two.
  std::vector<std::array<size_t, 3>> run() {
    std::vector<std::array<size_t, 3>> triangles;
    size_t left = points_.size(), at = 0, failures = 0;
    bool flat = false;  // accept ears without area, because there are no others
    while (left > 3) {
      if (is_ear(at, flat)) {
        triangles.push_back({before_[at], at, after_[at]});
        after_[before_[at]] = after_[at];
        before_[after_[at]] = before_[at];
        left--;
        failures = 0;
        flat = false;
      } else if (++failures > left) {
        if (flat || exhausted_) break;
        flat = true;
        failures = 0;
      }
      at = after_[at];
    }
    // The last triangle. The loop may end earlier, if no ear is left (for example in a polygon that
    // touches itself) or the limit is reached. Then the rest becomes a fan.
    for (size_t b = after_[at]; left > 2; left--, b = after_[b])
      triangles.push_back({at, b, after_[b]});
    return triangles;
  }

 private:
  bool is_ear(size_t b, bool flat) {
    const Point &pa = points_[before_[b]], &pb = points_[b], &pc = points_[after_[b]];
    const double size = area(pa, pb, pc);
    if (size < 0 || (size == 0) != flat) return false;
    for (size_t i = after_[after_[b]]; i != before_[b]; i = after_[i]) {
      size_t& left = own_ > 0 ? own_ : budget_;
      exhausted_ = left == 0;
      if (exhausted_) return false;
      left--;
      const Point& p = points_[i];
      // A face with a hole has a cut from its outline to the hole. Both sides of the cut have
      // corners at the same place.
      if (p == pa || p == pb || p == pc) continue;
      if (!flat && area(pa, pb, p) >= 0 && area(pb, pc, p) >= 0 && area(pc, pa, p) >= 0)
        return false;
    }
    return true;
  }

  const std::vector<Point>& points_;
  size_t& budget_;
  size_t own_;  // used before the budget
  bool exhausted_ = false;
  std::vector<size_t> before_, after_;
};

// Projects a face along the axis that is nearest to its normal, so that its corners are
// counterclockwise.
std::vector<Point> flattened(const TriangleMesh& mesh, const std::vector<uint32_t>& corners) {
  Vec3 normal = Vec3::Zero();
  const Vec3& first = mesh.vertices[corners[0]];
  for (size_t i = 2; i < corners.size(); i++)
    normal += (mesh.vertices[corners[i - 1]] - first).cross(mesh.vertices[corners[i]] - first);
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  Eigen::Index x = (axis + 1) % 3, y = (axis + 2) % 3;
  if (normal[axis] < 0) std::swap(x, y);
  std::vector<Point> points;
  points.reserve(corners.size());
  for (const uint32_t corner : corners)
    points.push_back({mesh.vertices[corner][x], mesh.vertices[corner][y]});
  return points;
}

bool is_convex(const std::vector<Point>& points) {
  for (size_t i = 0; i < points.size(); i++)
    if (area(points[i], points[(i + 1) % points.size()], points[(i + 2) % points.size()]) < 0)
      return false;
  return true;
}

}  // namespace

void Polygons::add(TriangleMesh& mesh, std::span<const uint32_t> corners) {
  if (corners.size() > 3) fans_.push_back({mesh.triangles.size(), corners.size() - 2});
  for (size_t i = 2; i < corners.size(); i++)
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

void Polygons::finish(TriangleMesh& mesh) const {
  std::vector<uint32_t> corners;
  size_t budget = kComparisons;
  for (const Fan& fan : fans_) {
    corners.assign({mesh.triangles[fan.first][0], mesh.triangles[fan.first][1]});
    for (size_t i = 0; i < fan.count; i++) corners.push_back(mesh.triangles[fan.first + i][2]);
    const std::vector<Point> points = flattened(mesh, corners);
    if (is_convex(points)) continue;
    const auto triangles = EarCutter(points, budget).run();
    for (size_t i = 0; i < fan.count; i++)
      for (size_t k = 0; k < 3; k++) mesh.triangles[fan.first + i][k] = corners[triangles[i][k]];
  }
}

}  // namespace kibori
