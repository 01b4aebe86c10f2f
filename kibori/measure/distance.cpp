// SPDX-License-Identifier: MIT
#include <kibori/measure/distance.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <embree3/rtcore.h>

#include <kibori/base/parallel.h>
#include <kibori/geometry/triangle_distance.h>

namespace kibori {
namespace {

Vec3 at(const Surface& surface, uint32_t v) {
  const auto& p = surface.vertices[v].position;
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

// Points spread evenly over the area. The triangles are used in order. A low-discrepancy sequence
// gives the position in each.
std::vector<Vec3> spread(const Surface& surface, int64_t samples) {
  double area = 0;
  const auto area_of = [&](const SurfaceTriangle& t) {
    const Vec3 a = at(surface, t[0]);
    return (at(surface, t[1]) - a).cross(at(surface, t[2]) - a).norm() / 2;
  };
  for (const SurfaceTriangle& t : surface.triangles) area += area_of(t);
  std::vector<Vec3> points;
  if (!(area > 0)) return points;
  const double each = area / static_cast<double>(samples);
  double passed = 0, next = 0.5 * each;
  for (const SurfaceTriangle& t : surface.triangles) {
    passed += area_of(t);
    for (; next < passed; next += each) {
      const auto i = static_cast<double>(points.size());
      double u = std::fmod(0.5 + i * 0.7548776662466927, 1),
             v = std::fmod(0.5 + i * 0.5698402909980532, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 a = at(surface, t[0]);
      points.push_back(a + u * (at(surface, t[1]) - a) + v * (at(surface, t[2]) - a));
    }
  }
  return points;
}

}  // namespace

struct DistanceTree::State {
  const Surface& surface;
  RTCDevice device;
  RTCScene scene;
  bool good;
};

DistanceTree::DistanceTree(const Surface& surface)
    : state_(new State{surface, rtcNewDevice(nullptr), nullptr, false}) {
  State& state = *state_;
  state.scene = rtcNewScene(state.device);
  const RTCGeometry geometry = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(surface.triangles.size()));
  rtcSetGeometryUserData(geometry, const_cast<Surface*>(&surface));
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* arguments) {
        const auto& of = *static_cast<const Surface*>(arguments->geometryUserPtr);
        Box box;
        for (const uint32_t v : of.triangles[arguments->primID]) box.include(at(of, v));
        RTCBounds& bounds = *arguments->bounds_o;
        // Positions are float32 already.
        bounds.lower_x = static_cast<float>(box.min.x());
        bounds.lower_y = static_cast<float>(box.min.y());
        bounds.lower_z = static_cast<float>(box.min.z());
        bounds.upper_x = static_cast<float>(box.max.x());
        bounds.upper_y = static_cast<float>(box.max.y());
        bounds.upper_z = static_cast<float>(box.max.z());
      },
      nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(state.scene);
  state.good = rtcGetDeviceError(state.device) == RTC_ERROR_NONE;
}
DistanceTree::~DistanceTree() {
  rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}
bool DistanceTree::good() const { return state_->good; }

double DistanceTree::distance(const Vec3& p) const {
  struct Search {
    const Surface& surface;
    Vec3 point;
    double min = std::numeric_limits<double>::infinity();
  } search{state_->surface, p};
  RTCPointQuery query = {};
  query.x = static_cast<float>(p.x());
  query.y = static_cast<float>(p.y());
  query.z = static_cast<float>(p.z());
  query.radius = std::numeric_limits<float>::infinity();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(
      state_->scene, &query, &context,
      [](RTCPointQueryFunctionArguments* arguments) {
        auto& found = *static_cast<Search*>(arguments->userPtr);
        const SurfaceTriangle& t = found.surface.triangles[arguments->primID];
        const double d = distance_to_triangle(found.point, at(found.surface, t[0]),
                                              at(found.surface, t[1]), at(found.surface, t[2]));
        if (!(d < found.min)) return false;
        found.min = d;
        // A little more than d, because the point was rounded for the tree.
        arguments->query->radius =
            static_cast<float>(d) * 1.0001f + 1e-6f * std::abs(arguments->query->x) +
            1e-6f * std::abs(arguments->query->y) + 1e-6f * std::abs(arguments->query->z);
        return true;
      },
      &search);
  return search.min;
}

Result<Distance> distance_from_to(const Surface& from, const Surface& to, int64_t samples,
                                  int threads) {
  if (from.triangles.empty() || to.triangles.empty())
    return Error{"one of the two surfaces is empty"};
  const DistanceTree tree(to);
  if (!tree.good())
    return Error{"not enough memory to measure a mesh of this size; simplify it first"};
  std::vector<Vec3> points = spread(from, samples);
  const size_t spread_count = points.size();
  std::vector<bool> used(from.vertices.size());
  for (const SurfaceTriangle& t : from.triangles)
    for (const uint32_t v : t) used[v] = true;
  for (uint32_t v = 0; v < from.vertices.size(); v++)
    if (used[v]) points.push_back(at(from, v));
  std::vector<double> distances(points.size());
  constexpr size_t kBlock = 1024;
  run_parallel(threads, (points.size() + kBlock - 1) / kBlock, [&](size_t block) {
    for (size_t i = block * kBlock; i < std::min(points.size(), (block + 1) * kBlock); i++)
      distances[i] = tree.distance(points[i]);
  });
  Distance result;
  double sum = 0, squares = 0;
  for (size_t i = 0; i < points.size(); i++) {
    if (i < spread_count) {
      sum += distances[i];
      squares += distances[i] * distances[i];
    }
    if (distances[i] <= result.max) continue;
    result.max = distances[i];
    result.at = points[i];
  }
  if (spread_count > 0) {
    result.mean = sum / static_cast<double>(spread_count);
    result.rms = std::sqrt(squares / static_cast<double>(spread_count));
  }
  return result;
}

double TwoSided::max() const { return std::max(there.max, back.max); }
double TwoSided::rms() const {
  return std::sqrt((there.rms * there.rms + back.rms * back.rms) / 2);
}

Result<TwoSided> two_sided_distance(const Surface& a, const Surface& b, int64_t samples,
                                    int threads) {
  const Result<Distance> there = distance_from_to(a, b, samples, threads);
  if (!there) return Error{there.error()};
  const Result<Distance> back = distance_from_to(b, a, samples, threads);
  if (!back) return Error{back.error()};
  return TwoSided{there.value(), back.value()};
}

}  // namespace kibori
