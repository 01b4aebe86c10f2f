// SPDX-License-Identifier: MIT
#include <kibori/measure/distance.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <embree3/rtcore.h>

#include <kibori/base/parallel.h>
#include <kibori/geometry/mesh_info.h>
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

// The nearest triangle so far.
struct DistanceTree::Search {
  const Surface& surface;
  Vec3 point;
  double min = std::numeric_limits<double>::infinity();
  bool sides = false;  // true: also compute `height`
  // Distance from the plane of the triangle that decides the side; negative behind it.
  double height = 0;

  // Finds the nearest triangle in a scene.
  void run(RTCScene scene) {
    RTCPointQuery query = {};
    query.x = static_cast<float>(point.x());
    query.y = static_cast<float>(point.y());
    query.z = static_cast<float>(point.z());
    query.radius = std::numeric_limits<float>::infinity();
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        scene, &query, &context,
        [](RTCPointQueryFunctionArguments* arguments) {
          auto& found = *static_cast<Search*>(arguments->userPtr);
          if (!found.visit(found.surface.triangles[arguments->primID])) return false;
          // A little more than the minimum, because the point was rounded for the tree.
          arguments->query->radius =
              static_cast<float>(found.min) * 1.0001f + 1e-6f * std::abs(arguments->query->x) +
              1e-6f * std::abs(arguments->query->y) + 1e-6f * std::abs(arguments->query->z);
          return true;
        },
        this);
  }

 private:
  // True if the triangle is nearer than all before.
  bool visit(const SurfaceTriangle& t) {
    const Vec3 a = at(surface, t[0]), b = at(surface, t[1]), c = at(surface, t[2]);
    const double d = distance_to_triangle(point, a, b, c);
    if (sides) look_at_side(d, (b - a).cross(c - a), point - a);
    if (!(d < min)) return false;
    min = d;
    return true;
  }
  // Decides on which side of the surface the point is. If several triangles share the nearest edge
  // or corner, the one whose plane is farthest from the point decides.
  void look_at_side(double d, const Vec3& normal, const Vec3& from_plane) {
    const double length = normal.norm();
    if (!(length > 0) || d > min * (1 + 1e-9) + 1e-12) return;
    const double here = normal.dot(from_plane) / length;
    if (d < min * (1 - 1e-9) - 1e-12 || std::abs(here) > std::abs(height)) height = here;
  }
};

double DistanceTree::distance(const Vec3& p) const {
  Search search{state_->surface, p};
  search.run(state_->scene);
  return search.min;
}

double DistanceTree::signed_distance(const Vec3& p) const {
  Search search{state_->surface, p};
  search.sides = true;
  search.run(state_->scene);
  return search.height < 0 ? -search.min : search.min;
}

namespace {

// The points of a surface at which distances are measured: first those spread over it, then its
// used vertices.
struct Samples {
  std::vector<Vec3> points;
  size_t spread_count = 0;
  std::vector<uint32_t> vertices;  // of the points after the first spread_count

  Samples(const Surface& surface, int64_t count) : points(spread(surface, count)) {
    spread_count = points.size();
    std::vector<bool> used(surface.vertices.size());
    for (const SurfaceTriangle& t : surface.triangles)
      for (const uint32_t v : t) used[v] = true;
    for (uint32_t v = 0; v < surface.vertices.size(); v++)
      if (used[v]) {
        points.push_back(at(surface, v));
        vertices.push_back(v);
      }
  }
  // The distance of each point. of(point) computes it.
  template <class Of>
  std::vector<double> distances(int threads, const Of& of) const {
    std::vector<double> result(points.size());
    constexpr size_t kBlock = 1024;
    run_parallel(threads, (points.size() + kBlock - 1) / kBlock, [&](size_t block) {
      for (size_t i = block * kBlock; i < std::min(points.size(), (block + 1) * kBlock); i++)
        result[i] = of(points[i]);
    });
    return result;
  }
  // Mean, and root of the mean square, of the points that are spread.
  void means(const std::vector<double>& distances, double& mean, double& rms) const {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < spread_count; i++) {
      sum += distances[i];
      squares += distances[i] * distances[i];
    }
    const double n = std::max(1.0, static_cast<double>(spread_count));
    mean = sum / n;
    rms = std::sqrt(squares / n);
  }
};

const char* const kNoSurface = "one of the two surfaces is empty";
const char* const kNoMemory = "not enough memory to measure a mesh of this size; simplify it first";

}  // namespace

Result<Distance> distance_from_to(const Surface& from, const Surface& to, int64_t samples,
                                  int threads) {
  if (from.triangles.empty() || to.triangles.empty()) return Error{kNoSurface};
  const DistanceTree tree(to);
  if (!tree.good()) return Error{kNoMemory};
  const Samples at(from, samples);
  const std::vector<double> distances =
      at.distances(threads, [&](const Vec3& p) { return tree.distance(p); });
  Distance result;
  at.means(distances, result.mean, result.rms);
  for (size_t i = 0; i < distances.size(); i++) {
    if (distances[i] <= result.max) continue;
    result.max = distances[i];
    result.at = at.points[i];
  }
  return result;
}

Result<Deviation> deviation_from(const Surface& surface, const Surface& target, int64_t samples,
                                 int threads) {
  if (surface.triangles.empty() || target.triangles.empty()) return Error{kNoSurface};
  if (const MeshInfo info = mesh_info(target); !info.closed)
    return Error{"has " + std::to_string(info.open_edges) +
                 " open edges, so its inside is unknown; repair it first"};
  const DistanceTree tree(target);
  if (!tree.good()) return Error{kNoMemory};
  const Samples at(surface, samples);
  const std::vector<double> distances =
      at.distances(threads, [&](const Vec3& p) { return tree.signed_distance(p); });
  Deviation result;
  at.means(distances, result.mean, result.rms);
  result.of_vertices.resize(surface.vertices.size());
  for (size_t i = 0; i < distances.size(); i++) {
    const double d = distances[i];
    if (i >= at.spread_count)
      result.of_vertices[at.vertices[i - at.spread_count]] = static_cast<float>(d);
    if (d > result.max) {
      result.max = d;
      result.max_at = at.points[i];
    }
    if (d < result.min) {
      result.min = d;
      result.min_at = at.points[i];
    }
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
