// SPDX-License-Identifier: MIT
#include <kibori/picture/picture.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>

#include <embree3/rtcore.h>

#include <kibori/base/parallel.h>
#include <kibori/picture/wood.h>

namespace kibori {
namespace {

using Rgb3 = Eigen::Array3d;  // linear light

constexpr double kPi = std::numbers::pi;
constexpr double kHalfAngle = 13 * kPi / 180;  // half of the view angle, across the shorter side
constexpr double kLightRadius = 0.16;          // of the lamp's disc, at distance 1
constexpr double kSmoothCosine =
    0.9;                  // normals with a smaller cosine between them belong to different faces
constexpr int kRows = 8;  // rows per piece of work
// The sky's light is kSky * (kHorizon + kAbove * z of its direction). kGround is the ground's.
const Rgb3 kSky(0.62, 0.64, 0.68);
constexpr double kGround = 0.34, kHorizon = 0.75, kAbove = 0.45;
constexpr double kMaxShadow = 3;   // shadows on the ground fade out, and end here [diagonals]
constexpr double kBlocked = 0.22;  // light that the object reflects onto itself

// Smoothing of the light. A pixel within one face needs only a few paths, because its light is a
// mean over nearby pixels of the same face. Each of three passes computes the mean over 5 x 5
// pixels. These are 1, 2 and 4 pixels apart.
constexpr int kPasses = 3;
constexpr int kMargin = 2 * (1 + 2 + 4) + 1;
constexpr int kReach = 2 * 4;       // of the last pass [pixels]
constexpr int kBandRows = 256;      // rows that are smoothed at once; bounds the memory
constexpr float kSameFace = 0.97f;  // cosine between the normals of a face's pixels
constexpr int kColumns = 128;       // columns that are smoothed at once; bounds the stack
constexpr float kSharpness = 8;     // see bell()
constexpr float kFlat = 0.1f;       // maximum slope between a face's pixels

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

template <int exponent>
double power(double x) {
  if constexpr (exponent == 0) return 1;
  const double half = power<exponent / 2>(x);
  return exponent % 2 ? half * half * x : half * half;
}

Rgb3 linear(const std::array<uint8_t, 3>& c) {
  static const std::array<double, 256> kLinear = [] {
    std::array<double, 256> table;
    for (size_t i = 0; i < table.size(); i++) table[i] = linear(static_cast<double>(i) / 255);
    return table;
  }();
  return {kLinear[c[0]], kLinear[c[1]], kLinear[c[2]]};
}

struct Pair {
  double x, y;
};
uint32_t mix(uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return h ^ h >> 16;
}
uint32_t reversed(uint32_t x) {
  x = x >> 16 | x << 16;
  x = (x & 0xff00ff00u) >> 8 | (x & 0x00ff00ffu) << 8;
  x = (x & 0xf0f0f0f0u) >> 4 | (x & 0x0f0f0f0fu) << 4;
  x = (x & 0xccccccccu) >> 2 | (x & 0x33333333u) << 2;
  return (x & 0xaaaaaaaau) >> 1 | (x & 0x55555555u) << 1;
}
// A permutation of the numbers. If two numbers have the same last n bits, so have their images, for
// each n (Laine and Karras, "Stratified sampling for stochastic transparency", 2011).
uint32_t permuted(uint32_t x, uint32_t seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  return x ^ x * 0x8d22f6e6u;
}
// Spreads the bits of a coordinate, so that two of them can be interleaved.
uint32_t spread(uint32_t x) {
  x &= 0xffffu;
  x = (x | x << 8) & 0x00ff00ffu;
  x = (x | x << 4) & 0x0f0f0f0fu;
  x = (x | x << 2) & 0x33333333u;
  return (x | x << 1) & 0x55555555u;
}

// Points in the unit square for the paths of a pixel. All pixels share one Sobol sequence,
// scrambled for each purpose (Burley, "Practical hash-based Owen scrambling", 2020). Pixels take
// their points in Z-order (Ahmed and Wonka, "Screen-space blue-noise diffusion", 2020). Therefore,
// the points of a square of pixels are as evenly spread as those of one pixel. So a few points per
// pixel suffice where neighbours are averaged.
class Sampler {
 public:
  Sampler(int x, int y)
      : order_(spread(static_cast<uint32_t>(x)) | spread(static_cast<uint32_t>(y)) << 1) {}
  // Point `i` of `count` points for one purpose. `count` is a power of two.
  Pair get(int i, int count, uint32_t purpose) const {
    const uint32_t number = order_ * static_cast<uint32_t>(count) + static_cast<uint32_t>(i),
                   seed = mix((purpose + 1) * 0x85ebca6bu),
                   index = permuted(reversed(number), seed);
    uint32_t y = index;  // the second dimension of Sobol's sequence
    y ^= y << 16;
    y ^= (y & 0x00ff00ffu) << 8;
    y ^= (y & 0x0f0f0f0fu) << 4;
    y ^= (y & 0x33333333u) << 2;
    y ^= (y & 0x55555555u) << 1;
    return {scrambled(index, seed ^ 0x2c1b3c6du), scrambled(y, seed ^ 0x297a2d39u)};
  }

 private:
  static double scrambled(uint32_t x, uint32_t seed) {
    return reversed(permuted(reversed(x), seed)) * 0x1p-32;
  }
  uint32_t order_;
};

// A normal and two directions across (Duff and others, "Building an orthonormal basis, revisited",
// 2017).
struct Frame {
  Vec3 u, v, n;
  explicit Frame(const Vec3& normal) : n(normal) {
    const double sign = n.z() < 0 ? -1 : 1, a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
    u = Vec3(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
    v = Vec3(b, sign + n.y() * n.y() * a, -n.y());
  }
};

// A point at distance `r` in the directions across, at the share `turn` of a full turn.
Vec3 across(const Frame& frame, double r, double turn) {
  const float angle = static_cast<float>(2 * kPi * turn);
  return r * static_cast<double>(std::cos(angle)) * frame.u +
         r * static_cast<double>(std::sin(angle)) * frame.v;
}
Vec3 on_disc(const Frame& frame, Pair p, double radius) {
  return frame.n + across(frame, radius * std::sqrt(p.x), p.y);
}
Vec3 on_hemisphere(const Frame& frame, Pair p) {  // cosine-weighted
  return across(frame, std::sqrt(p.x), p.y) + std::sqrt(std::max(0.0, 1 - p.x)) * frame.n;
}

class Scene {
 public:
  Scene(const Surface& surface) {
    device_ = rtcNewDevice(nullptr);
    scene_ = rtcNewScene(device_);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads 16 bytes at each vertex, but the stride is 12. rtcSetNewGeometryBuffer pads the
    // buffer, so the read at the last vertex stays inside it.
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, surface.vertices.size()));
    auto* triangles = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, surface.triangles.size()));
    good_ = vertices && triangles;
    if (good_) {
      for (size_t i = 0; i < surface.vertices.size(); i++)
        std::copy_n(surface.vertices[i].position.data(), 3, vertices + 3 * i);
      for (size_t i = 0; i < surface.triangles.size(); i++)
        std::copy_n(surface.triangles[i].data(), 3, triangles + 3 * i);
      rtcCommitGeometry(geometry);
      rtcAttachGeometry(scene_, geometry);
      rtcCommitScene(scene_);
    }
    rtcReleaseGeometry(geometry);
    good_ = good_ && rtcGetDeviceError(device_) == RTC_ERROR_NONE;
  }
  ~Scene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  bool good() const { return good_; }

  struct Hit {
    double distance;
    size_t triangle;
    double u, v;  // barycentric
  };
  std::optional<Hit> first(const Vec3& from, const Vec3& direction) const {
    RTCRayHit ray = {};
    set(ray.ray, from, direction, 0);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return Hit{static_cast<double>(ray.ray.tfar), ray.hit.primID, static_cast<double>(ray.hit.u),
               static_cast<double>(ray.hit.v)};
  }
  bool blocked(const Vec3& from, const Vec3& direction, double near) const {
    RTCRay ray = {};
    set(ray, from, direction, near);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0;
  }

 private:
  static void set(RTCRay& ray, const Vec3& from, const Vec3& direction, double near) {
    ray.org_x = static_cast<float>(from.x());
    ray.org_y = static_cast<float>(from.y());
    ray.org_z = static_cast<float>(from.z());
    ray.dir_x = static_cast<float>(direction.x());
    ray.dir_y = static_cast<float>(direction.y());
    ray.dir_z = static_cast<float>(direction.z());
    ray.tnear = static_cast<float>(near);
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
  }

  RTCDevice device_;
  RTCScene scene_;
  bool good_ = false;
};

// The inputs of smoothing for consecutive pixels, see Painter::Band.
struct Lists {
  const float *group, *x, *y, *z, *nx, *ny, *nz, *lamp, *blocked;
};
// Weights of one pass of smoothing, for some columns of a row, and sums.
struct Sums {
  float lamp_rate[kColumns], sky_rate[kColumns];
  float lamp_weight[kColumns] = {}, lamp[kColumns] = {};
  float sky_weight[kColumns] = {}, blocked[kColumns] = {};
};

// About exp(kSharpness * x) for x <= 0, without a call.
float bell(float x) {
  float y = 1 + x;
  y = (y + std::abs(y)) / 2;  // 0 if it is negative
  y *= y;
  y *= y;
  return y * y;
}

// Adds the neighbours `there` of the pixels `here` to the sums, if they are of the same face. GCC
// turns the loop into vectors because its count is constant and it has no calls or conditions.
void add_neighbours(const Lists& here, const Lists& there, float tap, Sums& __restrict sums) {
  const Lists a = here, b = there;
  for (int i = 0; i < kColumns; i++) {
    const float dx = b.x[i] - a.x[i], dy = b.y[i] - a.y[i], dz = b.z[i] - a.z[i];
    const float off = dx * a.nx[i] + dy * a.ny[i] + dz * a.nz[i];
    const float cosine = a.nx[i] * b.nx[i] + a.ny[i] * b.ny[i] + a.nz[i] * b.nz[i];
    const int same = (off * off <= kFlat * kFlat * (dx * dx + dy * dy + dz * dz)) &
                     (cosine >= kSameFace) & (a.group[i] == b.group[i]);
    const float weight = tap * static_cast<float>(same);
    // If the lights of two pixels differ by more than the noise, a shadow's border is between them.
    const float lamp_step = b.lamp[i] - a.lamp[i], sky_step = b.blocked[i] - a.blocked[i];
    const float by_lamp = weight * bell(lamp_step * lamp_step * sums.lamp_rate[i]),
                by_sky = weight * bell(sky_step * sky_step * sums.sky_rate[i]);
    sums.lamp_weight[i] += by_lamp;
    sums.lamp[i] += by_lamp * b.lamp[i];
    sums.sky_weight[i] += by_sky;
    sums.blocked[i] += by_sky * b.blocked[i];
  }
}

class Painter {
 public:
  Painter(const Surface& surface, std::span<const std::array<uint8_t, 3>> colors,
          const PictureOptions& options, const Scene& scene)
      : surface_(surface), colors_(colors), options_(options), scene_(scene) {
    for (const SurfaceTriangle& t : surface.triangles)
      for (const uint32_t v : t) box_.include(at(v));
    size_ = box_.size().norm();
    place_camera();
    const Vec3 side = right_, up = Vec3::UnitZ();
    // The lamp is on the left, above the object, and a little towards the camera.
    light_ = Frame((-0.75 * side - 0.55 * forward_flat() + 1.15 * up).normalized());
    for (const std::array<uint8_t, 3>& color : colors) linear_colors_.push_back(linear(color));
    log_ = log_of(options.plank.value_or(box_), options.log);
  }

  // Factors that convert the light that a point receives (Seen) into its colour, which is
  // lamp * by_lamp + (1 - blocked) * by_sky + blocked * by_object + mirrored * by_mirror + rest.
  struct Shade {
    Rgb3 by_lamp = Rgb3::Zero(), by_sky = Rgb3::Zero(), by_object = Rgb3::Zero();
    double by_mirror = 0, rest = 1;

    void operator+=(const Shade& other) {
      by_lamp += other.by_lamp;
      by_sky += other.by_sky;
      by_object += other.by_object;
      by_mirror += other.by_mirror;
      rest += other.rest;
    }
  };
  // The light at a point, measured by its rays.
  struct Seen {
    float lamp = 0;      // visible share of the lamp
    float blocked = 0;   // share of the sky that the object blocks
    float mirrored = 0;  // brightness in the direction that the varnish reflects
  };
  enum class Kind : uint8_t { white, ground, object, edge };
  // Pixels of a band of rows. Smoothing reads lists of floats, so that the compiler can use vector
  // instructions.
  struct Band {
    Band(int width_, int rows_)
        : width(width_), rows(rows_), kinds(count()), missed(count()), shades(count()) {
      for (std::vector<float>* list : {&group, &x, &y, &z, &nx, &ny, &nz, &lamp, &blocked,
                                       &mirrored, &next_lamp, &next_blocked})
        list->resize(count());
    }
    // The number of columns is rounded up to a multiple of kColumns. On both sides, a row has
    // kReach more columns, which belong to no face.
    size_t stride() const {
      return static_cast<size_t>((width + kColumns - 1) / kColumns * kColumns + 2 * kReach);
    }
    size_t count() const { return stride() * static_cast<size_t>(rows); }
    size_t index(int column, int row) const {
      return static_cast<size_t>(row) * stride() + static_cast<size_t>(kReach + column);
    }
    Lists from(size_t i) const {
      return {&group[i], &x[i], &y[i], &z[i], &nx[i], &ny[i], &nz[i], &lamp[i], &blocked[i]};
    }
    Eigen::Vector3f normal(size_t i) const { return {nx[i], ny[i], nz[i]}; }
    Seen seen(size_t i) const { return {lamp[i], blocked[i], mirrored[i]}; }

    int width, rows;
    std::vector<Kind> kinds;
    std::vector<uint8_t> missed;       // edges that trace() did not find
    std::vector<Shade> shades;         // means; of an edge, by_lamp is its colour
    std::vector<float> group;          // the kind if the light is smoothed, else 0
    std::vector<float> x, y, z;        // the point that the pixel shows
    std::vector<float> nx, ny, nz;     // normal there; zero if the pixel is not smoothed
    std::vector<float> lamp, blocked;  // means, see Seen
    std::vector<float> mirrored;
    std::vector<float> next_lamp, next_blocked;  // of the next pass
  };

  // Traces the paths of row `row` of the band. The row is row `y` of the picture.
  void trace(Band& band, int row, int y) const {
    for (int x = 0; x < band.width; x++) trace(band, band.index(x, row), x, y);
  }

  // Finds the pixels of a row next to a pixel of another face. They may show both faces, but their
  // few paths may have missed one. trace_missed traces them as edges.
  void find_missed(Band& band, int row) const {
    for (int x = 0; x < band.width; x++) {
      const size_t here = band.index(x, row);
      const auto differs = [&](int column, int other_row) {
        if (column < 0 || column >= band.width || other_row < 0 || other_row >= band.rows)
          return false;
        const size_t there = band.index(column, other_row);
        if (band.kinds[there] == Kind::edge) return false;
        return band.group[there] != band.group[here] ||
               (band.group[here] != 0 && band.normal(there).dot(band.normal(here)) < kSmoothCosine);
      };
      band.missed[here] =
          band.kinds[here] != Kind::edge && (differs(x - 1, row) || differs(x + 1, row) ||
                                             differs(x, row - 1) || differs(x, row + 1));
    }
  }
  void trace_missed(Band& band, int row, int y) const {
    for (int x = 0; x < band.width; x++)
      if (band.missed[band.index(x, row)]) trace_edge(band, band.index(x, row), x, y);
  }

  // One pass of smoothing for a row.
  void smooth(Band& band, int y, int distance) const {
    for (int x = 0; x < band.width; x += kColumns) smooth(band, x, y, distance);
  }

  std::array<uint8_t, 3> color(const Band& band, size_t pixel) const {
    if (band.kinds[pixel] == Kind::white) return {255, 255, 255};
    const Rgb3 light = band.kinds[pixel] == Kind::edge
                           ? band.shades[pixel].by_lamp
                           : shown(light_of(band.shades[pixel], band.seen(pixel)));
    std::array<uint8_t, 3> color;
    for (int c = 0; c < 3; c++)
      color[static_cast<size_t>(c)] =
          static_cast<uint8_t>(std::lround(255 * srgb(std::clamp(light[c], 0.0, 1.0))));
    return color;
  }

 private:
  Vec3 at(uint32_t v) const {
    const auto& p = surface_.vertices[v].position;
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
  }
  Vec3 forward_flat() const {
    const Vec3 flat(forward_.x(), forward_.y(), 0);
    return flat.norm() > 1e-6 ? Vec3(flat.normalized()) : up_;
  }

  // Places the camera as near as possible, so that the frame still contains the object.
  void place_camera() {
    forward_ = options_.view.normalized();
    const Vec3 upward = std::abs(forward_.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ();
    right_ = forward_.cross(upward).normalized();
    up_ = right_.cross(forward_);
    const double shorter = std::min(options_.width, options_.height);
    scale_ = 2 * std::tan(kHalfAngle) / shorter;
    const double half_x = 0.9 * scale_ * options_.width / 2,
                 half_y = 0.9 * scale_ * options_.height / 2;
    // All vertices must be in the frame. Each side of the frame is a plane through the eye. The
    // left and right planes that touch the object meet at one distance, the upper and lower ones at
    // another. The eye is at the larger distance.
    double max[4];
    std::fill_n(max, 4, -std::numeric_limits<double>::infinity());
    for (const SurfaceTriangle& t : surface_.triangles)
      for (const uint32_t v : t) {
        const Vec3 p = at(v);
        const double x = p.dot(right_), y = p.dot(up_), z = p.dot(forward_);
        max[0] = std::max(max[0], x - half_x * z);
        max[1] = std::max(max[1], -x - half_x * z);
        max[2] = std::max(max[2], y - half_y * z);
        max[3] = std::max(max[3], -y - half_y * z);
      }
    const double back =
        std::min(-(max[0] + max[1]) / (2 * half_x), -(max[2] + max[3]) / (2 * half_y));
    eye_ = (max[0] - max[1]) / 2 * right_ + (max[2] - max[3]) / 2 * up_ + back * forward_;
  }

  // Compresses bright light smoothly, so that highlights are not cut off. White stays white.
  static Rgb3 shown(const Rgb3& light) {
    return light.min(4.0) / (1 + 0.12 * (light.min(4.0) - 1).max(0.0));
  }

  static Rgb3 light_of(const Shade& shade, const Seen& seen) {
    return static_cast<double>(seen.lamp) * shade.by_lamp +
           static_cast<double>(1 - seen.blocked) * shade.by_sky +
           static_cast<double>(seen.blocked) * shade.by_object +
           static_cast<double>(seen.mirrored) * shade.by_mirror + shade.rest;
  }

  void smooth(Band& band, int x, int y, int distance) const {
    const size_t here = band.index(x, y);
    const float* group = &band.group[here];
    if (std::all_of(group, group + kColumns, [](float g) { return g == 0; })) return;
    // Noise (variance) of the mean over paths. Each path sees the lamp or does not.
    const float noise = 0.5f / static_cast<float>(paths_ * distance),
                per_path = 1 / static_cast<float>(paths_);
    const auto rate = [&](float seen) {
      return -1 / (4 * kSharpness * (noise + seen * (1 - seen) * per_path));
    };
    Sums sums;
    for (size_t i = 0; i < kColumns; i++) {
      sums.lamp_rate[i] = rate(band.lamp[here + i]);
      sums.sky_rate[i] = rate(band.blocked[here + i]);
    }
    constexpr float kTaps[] = {3.0f / 8, 1.0f / 4, 1.0f / 16};
    for (int dy = -2; dy <= 2; dy++) {
      const int row = y + dy * distance;
      if (row < 0 || row >= band.rows) continue;
      for (int dx = -2; dx <= 2; dx++)
        add_neighbours(band.from(here), band.from(band.index(x + dx * distance, row)),
                       kTaps[std::abs(dx)] * kTaps[std::abs(dy)], sums);
    }
    for (size_t i = 0; i < kColumns; i++) {
      band.next_lamp[here + i] = sums.lamp_weight[i] > 0 ? sums.lamp[i] / sums.lamp_weight[i] : 0;
      band.next_blocked[here + i] =
          sums.sky_weight[i] > 0 ? sums.blocked[i] / sums.sky_weight[i] : 0;
    }
  }

  // The first point that a path hits.
  struct Point {
    Kind kind = Kind::white;
    Shade shade;
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
    Vec3 start = Vec3::Zero(), mirrored = Vec3::Zero();  // of rays to the light
  };

  void trace(Band& band, size_t pixel, int x, int y) const {
    const Sampler sampler(x, y);
    Kind& kind = band.kinds[pixel];
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Shade all;
    all.rest = 0;
    Seen seen;
    for (int i = 0; i < paths_ && kind != Kind::edge; i++) {
      const Point point = point_along(x, y, sampler.get(i, paths_, 0));
      if (i == 0) {
        kind = point.kind;
        normal = point.normal.cast<float>();
        place(band, pixel, point);
      } else if (point.kind != kind ||
                 (kind != Kind::white && point.normal.cast<float>().dot(normal) < kSmoothCosine)) {
        kind = Kind::edge;
      }
      all += point.shade;
      look(point, sampler, i, paths_, seen);
    }
    if (kind == Kind::edge) return trace_edge(band, pixel, x, y);
    const double share = 1.0 / paths_;
    const float light = static_cast<float>(share);
    for (Rgb3* part : {&all.by_lamp, &all.by_sky, &all.by_object}) *part *= share;
    all.by_mirror *= share;
    all.rest *= share;
    band.shades[pixel] = all;
    band.lamp[pixel] = seen.lamp * light;
    band.blocked[pixel] = seen.blocked * light;
    band.mirrored[pixel] = seen.mirrored * light;
  }
  void trace_edge(Band& band, size_t pixel, int x, int y) const {
    const Sampler sampler(x, y);
    const int count = static_cast<int>(std::bit_ceil(static_cast<uint32_t>(options_.samples)));
    Rgb3 sum = Rgb3::Zero();
    for (int i = 0; i < options_.samples; i++) {
      const Point point = point_along(x, y, sampler.get(i, count, 0));
      Seen seen;
      look(point, sampler, i, count, seen);
      // Compresses brightness before the mean, so that edges against bright areas are smooth.
      sum += shown(light_of(point.shade, seen));
    }
    place(band, pixel, {});
    band.kinds[pixel] = Kind::edge;
    band.shades[pixel].by_lamp = sum / options_.samples;
  }
  static void place(Band& band, size_t pixel, const Point& point) {
    const bool smoothed = point.kind != Kind::white;
    band.group[pixel] = smoothed ? static_cast<float>(point.kind) : 0;
    band.x[pixel] = static_cast<float>(point.point.x());
    band.y[pixel] = static_cast<float>(point.point.y());
    band.z[pixel] = static_cast<float>(point.point.z());
    band.nx[pixel] = static_cast<float>(point.normal.x());
    band.ny[pixel] = static_cast<float>(point.normal.y());
    band.nz[pixel] = static_cast<float>(point.normal.z());
  }

  Point point_along(int x, int y, Pair in_pixel) const {
    const Vec3 direction = (forward_ + scale_ * (x + in_pixel.x - options_.width / 2.0) * right_ -
                            scale_ * (y + in_pixel.y - options_.height / 2.0) * up_)
                               .normalized();
    const auto hit = scene_.first(eye_, direction);
    return hit ? object(*hit, direction) : ground(direction);
  }

  // Traces one ray each from a point to the lamp, to the sky and in the mirrored direction. Adds
  // the results to `seen`.
  void look(const Point& point, const Sampler& sampler, int i, int count, Seen& seen) const {
    if (point.kind == Kind::white) return;
    const double near = 1e-5 * size_;
    const Vec3 lamp = on_disc(light_, sampler.get(i, count, 1), kLightRadius).normalized();
    if (lamp.dot(point.normal) > 0 && !scene_.blocked(point.start, lamp, near)) seen.lamp++;
    const Vec3 sky = on_hemisphere(Frame(point.normal), sampler.get(i, count, 2));
    if (scene_.blocked(point.start, sky, near)) seen.blocked++;
    if (point.kind == Kind::object)
      seen.mirrored +=
          point.mirrored.z() > -0.2 && !scene_.blocked(point.start, point.mirrored, near) ? 0.5f
                                                                                          : 0.06f;
  }

  // The ground is white, except for shadows, which fade with distance.
  Point ground(const Vec3& direction) const {
    const double height = box_.min.z() - 1e-4 * size_;
    const bool below = eye_.z() <= height;
    if (direction.z() >= -1e-6 || below) return {};
    Point seen;
    seen.point = eye_ + (height - eye_.z()) / direction.z() * direction;
    seen.normal = Vec3::UnitZ();
    const Vec3 out = seen.point - box_.centre();
    const double squared = (out.x() * out.x() + out.y() * out.y()) / (size_ * size_);
    if (squared > kMaxShadow * kMaxShadow) return {};
    const double near = std::exp(-squared * 0.6);
    seen.kind = Kind::ground;
    seen.start = seen.point;
    seen.shade.by_lamp = Rgb3::Constant(0.45 * near);
    seen.shade.by_sky = Rgb3::Constant(0.55 * near);
    seen.shade.rest = 1 - near;
    return seen;
  }

  Point object(const Scene::Hit& hit, const Vec3& direction) const {
    const SurfaceTriangle& t = surface_.triangles[hit.triangle];
    const Vec3 a = at(t[0]), b = at(t[1]), c = at(t[2]);
    Vec3 face = (b - a).cross(c - a);
    const double area = face.norm();
    face = area > 0 ? Vec3(face / area) : Vec3(-direction);
    const double weights[3] = {1 - hit.u - hit.v, hit.u, hit.v};
    Vec3 normal = Vec3::Zero();
    Rgb3 base = Rgb3::Zero();
    double wooden = 0, contrast = 0;
    for (size_t k = 0; k < 3; k++) {
      const SurfaceVertex& v = surface_.vertices[t[k]];
      const Vec3 n(static_cast<double>(v.normal[0]), static_cast<double>(v.normal[1]),
                   static_cast<double>(v.normal[2]));
      normal += weights[k] * (n.dot(face) > kSmoothCosine ? n : face);
      if (is_painted(v.paint)) {
        base +=
            weights[k] * linear({static_cast<uint8_t>(v.paint), static_cast<uint8_t>(v.paint >> 8),
                                 static_cast<uint8_t>(v.paint >> 16)});
      } else {
        base += weights[k] * (v.material < linear_colors_.size() ? linear_colors_[v.material]
                                                                 : linear({200, 160, 112}));
        wooden += weights[k];
        contrast += weights[k] *
                    (v.material < options_.contrasts.size() ? options_.contrasts[v.material] : 1);
      }
    }
    normal.normalize();
    if (normal.dot(direction) > 0) normal = -direction;  // seen from behind, at an edge
    const Vec3 point = weights[0] * a + weights[1] * b + weights[2] * c;
    Rgb3 albedo = base;
    double gloss = 0.3;
    if (options_.look == Look::wood && contrast > 0) {
      const WoodPoint wood = wood_at(log_, point);
      const Rgb3 light = (base * 1.28 + 0.03).min(0.95), dark = base * Rgb3(0.42, 0.34, 0.28);
      albedo = (1 - contrast) * base + contrast * (light + wood.dark * (dark - light));
      gloss = (1 - wooden) * gloss + wooden * wood.gloss;
    }
    Point seen;
    seen.kind = Kind::object;
    seen.point = point;
    seen.normal = normal;
    // Rays start above the surface. Otherwise they could hit it again, because of rounding.
    seen.start = point + face * (face.dot(direction) < 0 ? 2e-5 : -2e-5) * size_;
    seen.mirrored = direction - 2 * direction.dot(normal) * normal;
    // Reflections of the lamp and the sky in a thin varnish.
    const Vec3 half = (light_.n - direction).normalized();
    const double shine = power<38>(std::max(0.0, half.dot(normal))) * 0.22 * gloss;
    const double fresnel = 0.04 + 0.5 * power<5>(1 - std::min(1.0, -direction.dot(normal)));
    Shade& shade = seen.shade;
    shade.by_lamp =
        albedo * (1.35 * std::max(0.0, light_.n.dot(normal)) * Rgb3(1.0, 0.97, 0.92)) + shine;
    shade.by_sky =
        albedo * sky_[static_cast<size_t>(std::lround((normal.z() + 1) / 2 * (kSkies - 1)))];
    shade.by_object = kBlocked * albedo * albedo;
    shade.by_mirror = fresnel * gloss;
    shade.rest = 0;
    return seen;
  }

  // The light that an unblocked point receives from the sky and the ground, by the z of its normal.
  static constexpr int kSkies = 256;
  static std::array<Rgb3, kSkies> skies() {
    std::array<Rgb3, kSkies> skies;
    constexpr int kSteps = 64;
    for (int i = 0; i < kSkies; i++) {
      const double z = 2.0 * i / (kSkies - 1) - 1;
      const Frame frame(Vec3(std::sqrt(std::max(0.0, 1 - z * z)), 0, z));
      Rgb3 sum = Rgb3::Zero();
      for (int a = 0; a < kSteps; a++)
        for (int b = 0; b < kSteps; b++) {
          const double up = on_hemisphere(frame, {(a + 0.5) / kSteps, (b + 0.5) / kSteps}).z();
          sum += up < 0 ? Rgb3(Rgb3::Constant(kGround)) : Rgb3(kSky * (kHorizon + kAbove * up));
        }
      skies[static_cast<size_t>(i)] = sum / (kSteps * kSteps);
    }
    return skies;
  }

  const Surface& surface_;
  const std::span<const std::array<uint8_t, 3>> colors_;
  const PictureOptions& options_;
  const Scene& scene_;
  Box box_;
  double size_, scale_;
  Vec3 eye_, forward_, right_, up_;
  Frame light_ = Frame(Vec3::UnitZ());
  std::vector<Rgb3> linear_colors_;
  Log log_;
  const std::array<Rgb3, kSkies> sky_ = skies();
  // Number of paths of a pixel within one face: a power of two.
  const int paths_ = static_cast<int>(std::bit_floor(
      static_cast<uint32_t>(std::min(options_.samples, std::max(4, options_.samples / 12)))));
};

}  // namespace

std::optional<Vec3> view_named(const std::string& name) {
  if (name == "iso") return PictureOptions().view;
  if (name == "front") return Vec3(0, 1, -0.06);
  if (name == "back") return Vec3(0, -1, -0.06);
  if (name == "left") return Vec3(1, 0, -0.06);
  if (name == "right") return Vec3(-1, 0, -0.06);
  if (name == "top") return Vec3(0, 0, -1);
  if (name == "bottom") return Vec3(0, 0, 1);
  return std::nullopt;
}

Result<Image> draw_picture(const Surface& surface, std::span<const std::array<uint8_t, 3>> colors,
                           const PictureOptions& options) {
  if (surface.triangles.empty()) return Error{"there is no material to draw"};
  for (const int side : {options.width, options.height})
    if (side < 16 || side > 16384)
      return Error{"a picture must have 16 to 16384 pixels per side, not " + std::to_string(side)};
  if (!options.view.allFinite() || !(options.view.norm() > 0))
    return Error{"a picture needs a viewing direction"};
  const Scene scene(surface);
  if (!scene.good())
    return Error{"not enough memory to draw a mesh of this size; simplify it first"};
  const Painter painter(surface, colors, options, scene);
  Image image{options.width, options.height, {}};
  image.pixels.resize(static_cast<size_t>(options.width) * static_cast<size_t>(options.height));
  const size_t width = static_cast<size_t>(options.width);
  std::mutex guard;
  int done = 0;
  for (int begin = 0; begin < options.height; begin += kBandRows) {
    const int first = std::max(0, begin - kMargin),
              last = std::min(options.height, begin + kBandRows + kMargin), rows = last - first;
    Painter::Band band(options.width, rows);
    const auto for_rows = [&](auto&& f) {
      run_parallel(options.threads, static_cast<size_t>((rows + kRows - 1) / kRows), [&](size_t i) {
        const int low = static_cast<int>(i) * kRows;
        for (int y = low; y < std::min(low + kRows, rows); y++) f(y);
      });
    };
    for_rows([&](int y) {
      painter.trace(band, y, first + y);
      const std::lock_guard lock(guard);
      done++;
      const int all = options.height + 2 * kMargin * ((options.height - 1) / kBandRows);
      if (options.progress) options.progress(std::min(1.0, static_cast<double>(done) / all));
    });
    for_rows([&](int y) { painter.find_missed(band, y); });
    for_rows([&](int y) { painter.trace_missed(band, y, first + y); });
    for (int pass = 0; pass < kPasses; pass++) {
      for_rows([&](int y) { painter.smooth(band, y, 1 << pass); });
      std::swap(band.lamp, band.next_lamp);
      std::swap(band.blocked, band.next_blocked);
    }
    for (int y = begin; y < std::min(begin + kBandRows, options.height); y++)
      for (int x = 0; x < options.width; x++)
        image.pixels[static_cast<size_t>(y) * width + static_cast<size_t>(x)] =
            painter.color(band, band.index(x, y - first));
  }
  return image;
}

}  // namespace kibori
