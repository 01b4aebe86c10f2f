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
constexpr double kHalfAngle = 13 * kPi / 180;  // of view, across the shorter side
constexpr double kLightRadius = 0.16;          // of the light's disc, at distance 1
constexpr double kSmoothCosine =
    0.9;                  // vertex normals farther from the face than this belong to another face
constexpr int kRows = 8;  // of a piece of work

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}
double srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

Rgb3 linear(const std::array<uint8_t, 3>& c) {
  return {linear(c[0] / 255.0), linear(c[1] / 255.0), linear(c[2] / 255.0)};
}

// A point of the plastic-number sequence in the unit square, turned about by a pixel's own shift.
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
Vec3 on_hemisphere(const Frame& frame, Pair p) {  // by the cosine
  const double r = std::sqrt(p.x), a = 2 * kPi * p.y;
  return frame.world(r * std::cos(a), r * std::sin(a), std::sqrt(std::max(0.0, 1 - p.x)));
}

class Scene {
 public:
  Scene(const Surface& surface) {
    device_ = rtcNewDevice(nullptr);
    scene_ = rtcNewScene(device_);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    // Embree reads 16 bytes at each vertex, which the stride covers but for the last one: copies
    // are padded.
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
  std::optional<Hit> first(const Vec3& from, const Vec3& way) const {
    RTCRayHit ray = {};
    set(ray.ray, from, way, 0);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return Hit{static_cast<double>(ray.ray.tfar), ray.hit.primID, static_cast<double>(ray.hit.u),
               static_cast<double>(ray.hit.v)};
  }
  bool blocked(const Vec3& from, const Vec3& way, double near) const {
    RTCRay ray = {};
    set(ray, from, way, near);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene_, &context, &ray);
    return ray.tfar < 0;
  }

 private:
  static void set(RTCRay& ray, const Vec3& from, const Vec3& way, double near) {
    ray.org_x = static_cast<float>(from.x());
    ray.org_y = static_cast<float>(from.y());
    ray.org_z = static_cast<float>(from.z());
    ray.dir_x = static_cast<float>(way.x());
    ray.dir_y = static_cast<float>(way.y());
    ray.dir_z = static_cast<float>(way.z());
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
    // From the left, above, a little from the camera's side.
    light_ = (-0.75 * side - 0.55 * forward_flat() + 1.15 * up).normalized();
    log_ = log_of(options.plank.value_or(box_));
  }

  void row(int y, std::array<uint8_t, 3>* pixels) const {
    for (int x = 0; x < options_.width; x++) {
      const Sampler sampler(x, y);
      Rgb3 sum = Rgb3::Zero();
      for (int i = 0; i < options_.samples; i++) {
        const Pair p = sampler.get(i, 0);
        // Brightness is bent before the mean, so that edges against bright things are smooth.
        sum += shown(light_along(x + p.x, y + p.y, sampler, i));
      }
      for (int c = 0; c < 3; c++)
        pixels[x][static_cast<size_t>(c)] = static_cast<uint8_t>(
            std::lround(255 * srgb(std::clamp(sum[c] / options_.samples, 0.0, 1.0))));
    }
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

  // Puts the camera as near as the frame allows, from the view's direction.
  void place_camera() {
    forward_ = options_.view.normalized();
    const Vec3 upward = std::abs(forward_.z()) > 0.999 ? Vec3::UnitY() : Vec3::UnitZ();
    right_ = forward_.cross(upward).normalized();
    up_ = right_.cross(forward_);
    const double shorter = std::min(options_.width, options_.height);
    scale_ = 2 * std::tan(kHalfAngle) / shorter;
    const double half_x = 0.9 * scale_ * options_.width / 2,
                 half_y = 0.9 * scale_ * options_.height / 2;
    // What must be in the frame: all vertices. Each side of the frame is a plane through the eye;
    // the eye is where the planes of both pairs meet, at the distance of the farther pair.
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

  static Rgb3 shown(const Rgb3& light) {  // a soft shoulder: white stays white, nothing burns out
    return light.min(4.0) / (1 + 0.12 * (light.min(4.0) - 1).max(0.0));
  }

  Rgb3 light_along(double x, double y, const Sampler& sampler, int i) const {
    const Vec3 way = (forward_ + scale_ * (x - options_.width / 2.0) * right_ -
                      scale_ * (y - options_.height / 2.0) * up_)
                         .normalized();
    const auto hit = scene_.first(eye_, way);
    if (hit) return surface_light(*hit, way, sampler, i);
    return ground_light(way, sampler, i);
  }

  double sees_light(const Vec3& point, const Vec3& normal, const Sampler& sampler, int i) const {
    const Vec3 way = on_disc(Frame(light_), sampler.get(i, 1), kLightRadius).normalized();
    const double cosine = way.dot(normal);
    if (cosine <= 0) return 0;
    return scene_.blocked(point, way, 1e-5 * size_) ? 0 : cosine;
  }

  // White, but for shadows, which fade with distance.
  Rgb3 ground_light(const Vec3& way, const Sampler& sampler, int i) const {
    const double height = box_.min.z() - 1e-4 * size_;
    const bool below = eye_.z() <= height;
    if (way.z() >= -1e-6 || below) return Rgb3::Ones();
    const Vec3 point = eye_ + (height - eye_.z()) / way.z() * way;
    const Vec3 out = point - box_.centre();
    const double distance = std::hypot(out.x(), out.y()) / size_;
    const double near = std::exp(-distance * distance * 0.6);
    if (near < 0.004) return Rgb3::Ones();
    const Vec3 up = Vec3::UnitZ();
    const double key = sees_light(point, up, sampler, i) / light_.z();
    const bool sky =
        !scene_.blocked(point, on_hemisphere(Frame(up), sampler.get(i, 2)), 1e-5 * size_);
    const double lit = 0.45 * std::min(key, 1.2) + 0.55 * (sky ? 1 : 0);
    return Rgb3::Constant(1 - near * (1 - lit));
  }

  Rgb3 surface_light(const Scene::Hit& hit, const Vec3& way, const Sampler& sampler, int i) const {
    const SurfaceTriangle& t = surface_.triangles[hit.triangle];
    const Vec3 a = at(t[0]), b = at(t[1]), c = at(t[2]);
    Vec3 face = (b - a).cross(c - a);
    const double area = face.norm();
    face = area > 0 ? Vec3(face / area) : Vec3(-way);
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
    if (normal.dot(way) > 0) normal = -way;  // seen from behind, at an edge
    const Vec3 point = weights[0] * a + weights[1] * b + weights[2] * c;
    Rgb3 albedo = base;
    double gloss = 0.3;
    if (options_.look == Look::wood && contrast > 0) {
      const WoodPoint wood = wood_at(log_, point);
      const Rgb3 light = (base * 1.28 + 0.03).min(0.95), dark = base * Rgb3(0.42, 0.34, 0.28);
      albedo = (1 - contrast) * base + contrast * (light + wood.dark * (dark - light));
      gloss = (1 - wooden) * gloss + wooden * wood.gloss;
    }
    // Off the surface, or float32 would find it again.
    const Vec3 above = point + face * (face.dot(way) < 0 ? 2e-5 : -2e-5) * size_;
    const double key = sees_light(above, normal, sampler, i);
    const Vec3 sky = on_hemisphere(Frame(normal), sampler.get(i, 2));
    Rgb3 around = sky_light(above, sky, albedo);
    // A thin varnish: what of the light and the sky it mirrors.
    const Vec3 half = (light_ - way).normalized();
    const double shine =
        std::pow(std::max(0.0, half.dot(normal)), 38) * 0.22 * gloss * (key > 0 ? 1 : 0);
    const Vec3 mirrored = way - 2 * way.dot(normal) * normal;
    const double fresnel = 0.04 + 0.5 * std::pow(1 - std::min(1.0, -way.dot(normal)), 5);
    const double sheen =
        fresnel * gloss *
        (mirrored.z() > -0.2 && !scene_.blocked(above, mirrored, 1e-5 * size_) ? 0.5 : 0.06);
    return albedo * (1.35 * key * Rgb3(1.0, 0.97, 0.92) + around) + shine + sheen;
  }

  // From the sky, or from what is in its way: the ground, or the object itself in about the same
  // colour.
  Rgb3 sky_light(const Vec3& from, const Vec3& way, const Rgb3& albedo) const {
    if (scene_.blocked(from, way, 1e-5 * size_)) return 0.22 * albedo;
    if (way.z() < 0) return Rgb3::Constant(0.34);
    const double up = way.z();
    return Rgb3(0.62, 0.64, 0.68) * (0.75 + 0.45 * up);
  }

  const Surface& surface_;
  const std::span<const std::array<uint8_t, 3>> colors_;
  const PictureOptions& options_;
  const Scene& scene_;
  Box box_;
  double size_, scale_;
  Vec3 eye_, forward_, right_, up_, light_;
  Log log_;
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
  if (surface.triangles.empty()) return Error{"there is nothing to draw"};
  for (const int side : {options.width, options.height})
    if (side < 16 || side > 16384)
      return Error{"a picture has 16 to 16384 pixels a side, not " + std::to_string(side)};
  if (!options.view.allFinite() || !(options.view.norm() > 0))
    return Error{"a picture needs a direction to look in"};
  const Scene scene(surface);
  if (!scene.good()) return Error{"there is not enough memory to draw so many triangles"};
  const Painter painter(surface, colors, options, scene);
  Image image{options.width, options.height, {}};
  image.pixels.resize(static_cast<size_t>(options.width) * static_cast<size_t>(options.height));
  const int bands = (options.height + kRows - 1) / kRows;
  std::mutex guard;
  int done = 0;
  run_parallel(options.threads, static_cast<size_t>(bands), [&](size_t band) {
    const int begin = static_cast<int>(band) * kRows, end = std::min(begin + kRows, options.height);
    for (int y = begin; y < end; y++)
      painter.row(
          y, image.pixels.data() + static_cast<size_t>(y) * static_cast<size_t>(options.width));
    const std::lock_guard lock(guard);
    done++;
    if (options.progress) options.progress(static_cast<double>(done) / bands);
  });
  return image;
}

}  // namespace kibori
