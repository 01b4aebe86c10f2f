// SPDX-License-Identifier: MIT
#include "apps/studio/remains_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/edit/edit.h>

namespace kibori::studio {
namespace {

// The colour map Viridis, from distance 0 to the largest distance. Its colours remain distinct for
// colour-blind people and in grey.
constexpr std::array<std::array<double, 3>, 6> kRemainsColors{
    {{253, 231, 37}, {122, 209, 81}, {34, 168, 132}, {42, 120, 142}, {65, 68, 135}, {68, 1, 84}}};

uint32_t color_at(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kRemainsColors.size() - 1);
  const size_t i = std::min(static_cast<size_t>(at), kRemainsColors.size() - 2);
  uint32_t color = 0xff000000;
  for (unsigned c = 0; c < 3; c++) {
    const double mixed =
        kRemainsColors[i][c] +
        (at - static_cast<double>(i)) * (kRemainsColors[i + 1][c] - kRemainsColors[i][c]);
    color |= static_cast<uint32_t>(std::lround(mixed)) << (8 * c);
  }
  return color;
}

// Rounds up to 1, 1.5, 2, 3, 4, 5, 6 or 8, times a power of ten.
double round_up(double x) {
  const double ten = std::pow(10, std::floor(std::log10(std::max(x, 1e-6))));
  for (const double times : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (x <= times * ten) return times * ten;
  return 10 * ten;
}

Vec3 place_of(const SurfaceVertex& v) { return {v.position[0], v.position[1], v.position[2]}; }

}  // namespace

std::vector<RemainsMap::Key> RemainsMap::key_of(const kibori::BodyList& bodies, BodyId worked_on) {
  std::vector<Key> key;
  for (const Body& body : bodies.all)
    if (body.id == worked_on)
      key.push_back({body.id, body.pose, 0});
    else if (body.no_go)
      key.push_back({body.id, body.pose, body.model.content_hash()});
  return key;
}

bool RemainsMap::is_of(const kibori::BodyList& bodies, BodyId worked_on, StepId) const {
  return key_ == key_of(bodies, worked_on);
}

std::unique_ptr<RemainsMap> RemainsMap::make(const kibori::BodyList& bodies, BodyId worked_on,
                                             const LiveSurface& surface, double volume_mm3) {
  const Result<std::shared_ptr<const NoGo>> no_go = no_go_of(bodies, worked_on);
  if (!no_go || !no_go.value()) return nullptr;
  auto map = std::make_unique<RemainsMap>();
  map->body_ = worked_on;
  map->key_ = key_of(bodies, worked_on);
  map->wall_ = extract_surface(no_go.value()->model().snapshot());
  if (map->wall_.triangles.empty()) return nullptr;
  map->tree_.emplace(map->wall_);
  if (!map->tree_->good()) return nullptr;
  const Body& body = *bodies.find(worked_on);
  Removed within;
  contact(TriDexel(body.model, body.material_bounds), no_go.value()->solid(), {}, within);
  map->within_mm3_ =
      std::min(volume_mm3, within.volume() * std::pow(body.model.lattice.pitch_mm, 3));
  double max = 0;
  const ChunkRange range = surface_chunks(body.model.lattice);
  for (int x = range.low.x(); x < range.high.x(); x++)
    for (int y = range.low.y(); y < range.high.y(); y++)
      for (int z = range.low.z(); z < range.high.z(); z++)
        for (const SurfaceVertex& v : surface.chunk({x, y, z}).vertices)
          max = std::max(max, map->tree_->distance(place_of(v)));
  map->scale_mm_ = round_up(std::max(max, body.model.lattice.pitch_mm));
  return map;
}

SurfaceChunk RemainsMap::paint(SurfaceChunk chunk, const Index3& at) {
  Part part;
  std::vector<double> distances;
  distances.reserve(chunk.vertices.size());
  for (SurfaceVertex& v : chunk.vertices) {
    distances.push_back(tree_->distance(place_of(v)));
    v.paint = color_at(distances.back() / scale_mm_);
    part.max = std::max(part.max, distances.back());
  }
  for (const SurfaceTriangle& t : chunk.triangles) {
    const Vec3 a = place_of(chunk.vertices[t[0]]), b = place_of(chunk.vertices[t[1]]),
               c = place_of(chunk.vertices[t[2]]);
    const double area = 0.5 * std::sqrt(Vec3((b - a).cross(c - a)).squaredNorm());
    part.area += area;
    part.sum += area * (distances[t[0]] + distances[t[1]] + distances[t[2]]) / 3;
  }
  if (chunk.triangles.empty())
    parts_.erase(at);
  else
    parts_[at] = part;
  return chunk;
}

std::vector<uint8_t> RemainsMap::message(double volume_mm3) const {
  Remains message;
  message.scale = scale_mm_;
  message.volume = std::max(0.0, volume_mm3 - within_mm3_);
  double area = 0;
  for (const auto& [at, part] : parts_) {
    message.max = std::max(message.max, part.max);
    message.mean += part.sum;
    area += part.area;
  }
  message.mean = area > 0 ? message.mean / area : 0;
  return encode(message);
}

}  // namespace kibori::studio
