// SPDX-License-Identifier: MIT
#include <kibori/picture/picture.h>

#include <algorithm>
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
constexpr double kLightRadius = 0.16;          // of the light's disc, at distance 1
constexpr double kSmoothCosine =
    0.9;                  // vertex normals farther from the face than this belong to another face
constexpr int kRows = 8;  // per piece of work
// The sky's light from the horizon and from straight above, and the ground's.
const Rgb3 kSky(0.62, 0.64, 0.68);
constexpr double kGround = 0.34, kHorizon = 0.75, kAbove = 0.45;
constexpr double kBlocked = 0.22;  // light from the object itself, as a share of its colour

// Smoothing of the light: a pixel within one face needs a few paths only. Its light is a mean over
// pixels nearby on the same face. There are three passes over a square of 5 x 5 pixels. The
// distance between these pixels is 1, 2 and 4.
constexpr int kPasses = 3;
constexpr int kMargin = 2 * (1 + 2 + 4) + 1;
constexpr int kBandRows = 256;      // rows that are smoothed at once; bounds the memory
constexpr double kSameFace = 0.97;  // cosine between the normals of a face's pixels

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

Rgb3 linear(const std::array<uint8_t, 3>& c) {
  return {linear(c[0] / 255.0), linear(c[1] / 255.0), linear(c[2] / 255.0)};
}

// A point of the plastic-number sequence in the unit square, shifted by a pixel's own offset.
struct Pair {
  double x, y;
};
double fraction(double x) { return x - std::floor(x); }
uint32_t mix(uint32_t h) {
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return h ^ h >> 16;
}
class Sampler {
 public:
  Sampler(int x, int y)
      : seed_(mix(static_cast<uint32_t>(x) + mix(static_cast<uint32_t>(y) + 0x9e3779b9u))) {}
  // The i-th of the pixel's points for one purpose.
  Pair get(int i, uint32_t purpose) const {
    const uint32_t h = mix(seed_ + purpose * 0x85ebca6bu);
    return {fraction(h * 0x1p-32 + i * 0.7548776662466927),
            fraction(mix(h) * 0x1p-32 + i * 0.5698402909980532)};
  }

 private:
  uint32_t seed_;
};

struct Frame {
  Vec3 u, v, n;
  explicit Frame(const Vec3& normal) : n(normal) {
    u = (std::abs(n.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitY()).cross(n).normalized();
    v = n.cross(u);
  }
  Vec3 world(double x, double y, double z) const { return x * u + y * v + z * n; }
};

Vec3 on_disc(const Frame& frame, Pair p, double radius) {
  const double r = radius * std::sqrt(p.x), a = 2 * kPi * p.y;
  return frame.n + frame.world(r * std::cos(a), r * std::sin(a), 0);
}
Vec3 on_hemisphere(const Frame& frame, Pair p) {  // cosine-weighted
  const double r = std::sqrt(p.x), a = 2 * kPi * p.y;
  return frame.world(r * std::cos(a), r * std::sin(a), std::sqrt(std::max(0.0, 1 - p.x)));
}

class Scene {
 public:
  Scene(const Surface& surface) {
    device_ = rtcNewDevice(nullptr);
    scene_ = rtcNewScene(device_);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads 16 bytes at each vertex. The stride covers this except at the last vertex, so
    // copies are padded.
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
    // From the upper left, slightly on the camera's side.
    light_ = (-0.75 * side - 0.55 * forward_flat() + 1.15 * up).normalized();
    log_ = log_of(options.plank.value_or(box_), options.log);
  }

  // The light of the lamp and of the sky at a point. The colour is
  // seen * by_lamp + (1 - blocked) * by_sky + blocked * by_object + rest.
  struct Shade {
    Rgb3 by_lamp = Rgb3::Zero(), by_sky = Rgb3::Zero(), by_object = Rgb3::Zero(),
         rest = Rgb3::Ones();
    double seen = 0;     // share of the lamp that the point sees
    double blocked = 0;  // share of the sky that the object blocks
    Rgb3 light() const {
      return seen * by_lamp + (1 - blocked) * by_sky + blocked * by_object + rest;
    }
  };
  enum class Kind : uint8_t { white, ground, object, edge };
  struct Pixel {
    Kind kind = Kind::white;
    Shade shade;                // mean
    Rgb3 shown = Rgb3::Ones();  // of an edge
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
    double seen_before = 0, blocked_before = 0;  // of the last pass
  };

  // Traces the light paths of a row.
  void trace(int y, Pixel* pixels) const {
    for (int x = 0; x < options_.width; x++) pixels[x] = trace(x, y);
  }

  // One pass of smoothing for a row. `pixels`: rows of the band, which begins at row 0.
  void smooth(std::vector<Pixel>& pixels, int rows, int y, int distance) const {
    constexpr double kTaps[] = {3.0 / 8, 1.0 / 4, 1.0 / 16};
    const int width = options_.width;
    const auto at = [&](int px, int py) -> Pixel& {
      return pixels[static_cast<size_t>(py) * static_cast<size_t>(width) + static_cast<size_t>(px)];
    };
    for (int x = 0; x < width; x++) {
      Pixel& pixel = at(x, y);
      if (pixel.kind != Kind::ground && pixel.kind != Kind::object) continue;
      double sum = 0, seen = 0, blocked = 0;
      // The noise of paths that see the lamp or do not.
      const double noise = 0.5 / paths_ / distance,
                   spread_seen = noise + pixel.seen_before * (1 - pixel.seen_before) / paths_,
                   spread_blocked =
                       noise + pixel.blocked_before * (1 - pixel.blocked_before) / paths_;
      double seen_sum = 0;
      for (int dy = -2; dy <= 2; dy++)
        for (int dx = -2; dx <= 2; dx++) {
          const int px = x + dx * distance, py = y + dy * distance;
          if (px < 0 || px >= width || py < 0 || py >= rows) continue;
          const Pixel& other = at(px, py);
          if (other.kind != pixel.kind || other.normal.dot(pixel.normal) < kSameFace) continue;
          const Vec3 apart = other.point - pixel.point;
          if (std::abs(apart.dot(pixel.normal)) >
              0.1 * std::sqrt(apart.squaredNorm()) + 1e-9 * size_)
            continue;
          const double weight = kTaps[std::abs(dx)] * kTaps[std::abs(dy)];
          // Lights that differ by more than the noise are the border of a shadow.
          const double by_seen = other.seen_before - pixel.seen_before,
                       by_blocked = other.blocked_before - pixel.blocked_before;
          const double w = weight * std::exp(-by_blocked * by_blocked / (4 * spread_blocked)),
                       ws = weight * std::exp(-by_seen * by_seen / (4 * spread_seen));
          sum += w;
          blocked += w * other.blocked_before;
          seen_sum += ws;
          seen += ws * other.seen_before;
        }
      pixel.shade.seen = seen / seen_sum;
      pixel.shade.blocked = blocked / sum;
    }
  }

  std::array<uint8_t, 3> color(const Pixel& pixel) const {
    const Rgb3 light = pixel.kind == Kind::edge ? pixel.shown : shown(pixel.shade.light());
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

  // Moves the camera as near as the frame allows, along the view direction.
  void place_camera() {
    forward_ = options_.view.normalized();
    const Vec3 upward = std::abs(forward_.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ();
    right_ = forward_.cross(upward).normalized();
    up_ = right_.cross(forward_);
    const double shorter = std::min(options_.width, options_.height);
    scale_ = 2 * std::tan(kHalfAngle) / shorter;
    const double half_x = 0.9 * scale_ * options_.width / 2,
                 half_y = 0.9 * scale_ * options_.height / 2;
    // All vertices must be in the frame. Each side of the frame is a plane through the eye. The eye
    // is where the planes of both pairs meet, at the distance of the farther pair.
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

  // a soft shoulder: white stays white, and highlights do not clip
  static Rgb3 shown(const Rgb3& light) {
    return light.min(4.0) / (1 + 0.12 * (light.min(4.0) - 1).max(0.0));
  }

  // A point that a path sees first.
  struct Seen {
    Kind kind = Kind::white;
    Shade shade;
    Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  };

  Pixel trace(int x, int y) const {
    const Sampler sampler(x, y);
    const auto path = [&](int i) {
      const Pair p = sampler.get(i, 0);
      return seen_along(x + p.x, y + p.y, sampler, i);
    };
    Pixel pixel;
    Rgb3 sum = Rgb3::Zero();
    Shade all;
    all.rest = Rgb3::Zero();
    for (int i = 0; i < paths_; i++) {
      const Seen seen = path(i);
      if (i == 0) {
        pixel.kind = seen.kind;
        pixel.point = seen.point;
        pixel.normal = seen.normal;
      } else if (seen.kind != pixel.kind || seen.normal.dot(pixel.normal) < kSmoothCosine) {
        if (!(seen.kind == Kind::white && pixel.kind == Kind::white)) pixel.kind = Kind::edge;
      }
      // Compresses brightness before the mean, so that edges against bright areas are smooth.
      sum += shown(seen.shade.light());
      all.by_lamp += seen.shade.by_lamp;
      all.by_sky += seen.shade.by_sky;
      all.by_object += seen.shade.by_object;
      all.rest += seen.shade.rest;
      all.seen += seen.shade.seen;
      all.blocked += seen.shade.blocked;
    }
    if (pixel.kind == Kind::edge) {
      for (int i = paths_; i < options_.samples; i++) sum += shown(path(i).shade.light());
      pixel.shown = sum / options_.samples;
      return pixel;
    }
    for (Rgb3* part : {&all.by_lamp, &all.by_sky, &all.by_object, &all.rest}) *part /= paths_;
    all.seen /= paths_;
    all.blocked /= paths_;
    pixel.shade = all;
    return pixel;
  }

  Seen seen_along(double x, double y, const Sampler& sampler, int i) const {
    const Vec3 direction = (forward_ + scale_ * (x - options_.width / 2.0) * right_ -
                            scale_ * (y - options_.height / 2.0) * up_)
                               .normalized();
    const auto hit = scene_.first(eye_, direction);
    if (hit) return object(*hit, direction, sampler, i);
    return ground(direction, sampler, i);
  }

  double sees_lamp(const Vec3& point, const Vec3& normal, const Sampler& sampler, int i) const {
    const Vec3 direction = on_disc(Frame(light_), sampler.get(i, 1), kLightRadius).normalized();
    return direction.dot(normal) > 0 && !scene_.blocked(point, direction, 1e-5 * size_) ? 1 : 0;
  }

  // White, except for shadows, which fade with distance.
  Seen ground(const Vec3& direction, const Sampler& sampler, int i) const {
    const double height = box_.min.z() - 1e-4 * size_;
    const bool below = eye_.z() <= height;
    if (direction.z() >= -1e-6 || below) return {};
    Seen seen;
    seen.point = eye_ + (height - eye_.z()) / direction.z() * direction;
    seen.normal = Vec3::UnitZ();
    const Vec3 out = seen.point - box_.centre();
    const double distance = std::hypot(out.x(), out.y()) / size_;
    const double near = std::exp(-distance * distance * 0.6);
    if (near < 0.004) return {};
    seen.kind = Kind::ground;
    Shade& shade = seen.shade;
    shade.seen = sees_lamp(seen.point, seen.normal, sampler, i);
    shade.blocked = scene_.blocked(seen.point, on_hemisphere(Frame(seen.normal), sampler.get(i, 2)),
                                   1e-5 * size_);
    shade.by_lamp = Rgb3::Constant(0.45 * near);
    shade.by_sky = Rgb3::Constant(0.55 * near);
    shade.rest = Rgb3::Constant(1 - near);
    return seen;
  }

  Seen object(const Scene::Hit& hit, const Vec3& direction, const Sampler& sampler, int i) const {
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
      if (v.paint) {
        base +=
            weights[k] * linear({static_cast<uint8_t>(v.paint), static_cast<uint8_t>(v.paint >> 8),
                                 static_cast<uint8_t>(v.paint >> 16)});
      } else {
        base += weights[k] * linear(v.material < colors_.size()
                                        ? colors_[v.material]
                                        : std::array<uint8_t, 3>{200, 160, 112});
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
    // Starts above the surface, because float32 would hit the surface again.
    const Vec3 above = point + face * (face.dot(direction) < 0 ? 2e-5 : -2e-5) * size_;
    Seen seen{Kind::object, {}, point, normal};
    Shade& shade = seen.shade;
    shade.seen = sees_lamp(above, normal, sampler, i);
    shade.blocked =
        scene_.blocked(above, on_hemisphere(Frame(normal), sampler.get(i, 2)), 1e-5 * size_);
    // A thin varnish: its reflection of the light and the sky.
    const Vec3 half = (light_ - direction).normalized();
    const double shine = std::pow(std::max(0.0, half.dot(normal)), 38) * 0.22 * gloss;
    const Vec3 mirrored = direction - 2 * direction.dot(normal) * normal;
    const double fresnel = 0.04 + 0.5 * std::pow(1 - std::min(1.0, -direction.dot(normal)), 5);
    const double sheen =
        fresnel * gloss *
        (mirrored.z() > -0.2 && !scene_.blocked(above, mirrored, 1e-5 * size_) ? 0.5 : 0.06);
    shade.by_lamp =
        albedo * (1.35 * std::max(0.0, light_.dot(normal)) * Rgb3(1.0, 0.97, 0.92)) + shine;
    shade.by_sky =
        albedo * sky_[static_cast<size_t>(std::lround((normal.z() + 1) / 2 * (kSkies - 1)))];
    shade.by_object = kBlocked * albedo * albedo;
    shade.rest = Rgb3::Constant(sheen);
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
  Vec3 eye_, forward_, right_, up_, light_;
  Log log_;
  const std::array<Rgb3, kSkies> sky_ = skies();
  const int paths_ = std::min(options_.samples, std::max(4, options_.samples / 8));
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
    std::vector<Painter::Pixel> pixels(width * static_cast<size_t>(rows));
    const auto for_rows = [&](auto&& f) {
      run_parallel(options.threads, static_cast<size_t>((rows + kRows - 1) / kRows), [&](size_t i) {
        const int low = static_cast<int>(i) * kRows;
        for (int y = low; y < std::min(low + kRows, rows); y++)
          f(y, pixels.data() + static_cast<size_t>(y) * width);
      });
    };
    for_rows([&](int y, Painter::Pixel* row) {
      painter.trace(first + y, row);
      const std::lock_guard lock(guard);
      done++;
      const int all = options.height + 2 * kMargin * ((options.height - 1) / kBandRows);
      if (options.progress) options.progress(std::min(1.0, static_cast<double>(done) / all));
    });
    for (int pass = 0; pass < kPasses; pass++) {
      for_rows([&](int, Painter::Pixel* row) {
        for (size_t x = 0; x < width; x++) {
          row[x].seen_before = row[x].shade.seen;
          row[x].blocked_before = row[x].shade.blocked;
        }
      });
      for_rows([&](int y, Painter::Pixel*) { painter.smooth(pixels, rows, y, 1 << pass); });
    }
    for (int y = begin; y < std::min(begin + kBandRows, options.height); y++)
      for (size_t x = 0; x < width; x++)
        image.pixels[static_cast<size_t>(y) * width + x] =
            painter.color(pixels[static_cast<size_t>(y - first) * width + x]);
  }
  return image;
}

}  // namespace kibori
