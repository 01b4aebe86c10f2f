// SPDX-License-Identifier: MIT
#include "bench/peers/openvdb_carve.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#ifdef __AVX512F__
#include <immintrin.h>
#endif

namespace kibori_bench {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::MaskGrid;

constexpr float kBand = 3.0f;
constexpr int kOffset = 8;  // the cube occupies voxels [8, 8 + n): one child of the root

FloatGrid::Ptr solid_levelset(int n) {
  auto grid = FloatGrid::create(kBand);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto& tree = grid->tree();
  tree.fill(openvdb::CoordBBox(Coord(kOffset), Coord(kOffset + n - 1)), -kBand, false);
  FloatGrid::Accessor access(tree);
  const float centre = kOffset + static_cast<float>(n - 1) * 0.5f,
              half = static_cast<float>(n) * 0.5f;
  const auto distance = [&](int i, int j, int k) {
    const float x = std::fabs(static_cast<float>(i) - centre) - half,
                y = std::fabs(static_cast<float>(j) - centre) - half,
                z = std::fabs(static_cast<float>(k) - centre) - half;
    const float m = std::max(x, std::max(y, z));
    if (m <= 0) return m;
    const float a = std::max(x, 0.f), b = std::max(y, 0.f), c = std::max(z, 0.f);
    return std::sqrt(a * a + b * b + c * c);
  };
  const auto deep = [&](int a) { return a >= kOffset + 8 && a < kOffset + n - 8; };
  for (int i = kOffset - 8; i < kOffset + n + 8; i += 8)
    for (int j = kOffset - 8; j < kOffset + n + 8; j += 8)
      for (int k = kOffset - 8; k < kOffset + n + 8; k += 8) {
        if (deep(i) && deep(j) && deep(k)) continue;
        float values[512];
        bool any = false;
        for (int q = 0; q < 512; q++) {
          const float s = distance(i + q / 64, j + q / 8 % 8, k + q % 8);
          any |= std::fabs(s) < kBand;
          values[q] = std::clamp(s, -kBand, kBand);
        }
        if (!any) continue;
        auto* leaf = access.touchLeaf(Coord(i, j, k));
        for (openvdb::Index q = 0; q < 512; q++) {
          if (std::fabs(values[q]) < kBand)
            leaf->setValueOn(q, values[q]);
          else
            leaf->setValueOff(q, values[q]);
        }
      }
  return grid;
}

struct Near {
  // Squared distances from the ball's centre to the nearest and farthest voxel of a leaf.
  float min2, max2;
};
Near leaf_distance(const Coord& origin, Point c) {
  Near d{0, 0};
  const float p[3] = {c.x, c.y, c.z};
  for (int a = 0; a < 3; a++) {
    const float lo = static_cast<float>(origin[a]) - p[a],
                hi = p[a] - static_cast<float>(origin[a] + 7);
    const float nearest = std::max({lo, hi, 0.f}),
                farthest = std::max(std::fabs(lo), std::fabs(hi));
    d.min2 += nearest * nearest;
    d.max2 += farthest * farthest;
  }
  return d;
}

template <class F>
void for_leaves(Point c, float reach, F&& f) {
  const auto low = [&](float x) { return static_cast<int>(std::floor(x - reach)) & ~7; };
  const auto high = [&](float x) { return static_cast<int>(std::ceil(x + reach)); };
  for (int i = low(c.x); i <= high(c.x); i += 8)
    for (int j = low(c.y); j <= high(c.y); j += 8)
      for (int k = low(c.z); k <= high(c.z); k += 8) f(Coord(i, j, k));
}

void stamp_levelset(FloatGrid::Accessor& access, Point c, float radius) {
  const float outside2 = (radius + kBand) * (radius + kBand),
              inside2 = (radius - kBand) * (radius - kBand);
  for_leaves(c, radius + kBand, [&](const Coord& origin) {
    const Near d = leaf_distance(origin, c);
    if (d.min2 >= outside2) return;
    auto* leaf = access.probeLeaf(origin);
    if (d.max2 <= inside2) {
      if (leaf || access.getValue(origin) < 0) access.addTile(1, origin, kBand, false);
      return;
    }
    if (!leaf) {
      if (access.getValue(origin) > 0) return;
      leaf = access.touchLeaf(origin);
    }
    float* values = leaf->buffer().data();
    auto& active =
        const_cast<openvdb::FloatTree::LeafNodeType::NodeMaskType&>(leaf->getValueMask());
    uint64_t any = 0;
    bool dead = false;
#ifdef __AVX512F__
    const __m512 r = _mm512_set1_ps(radius), band = _mm512_set1_ps(kBand),
                 minus = _mm512_set1_ps(-kBand);
    float z2[16];
    for (int q = 0; q < 16; q++) {
      const float dz = static_cast<float>(origin[2] + (q & 7)) - c.z;
      z2[q] = dz * dz;
    }
    const __m512 vz = _mm512_loadu_ps(z2);
    __m512 min = band;
    for (int a = 0; a < 8; a++) {
      const float dx = static_cast<float>(origin[0] + a) - c.x, dx2 = dx * dx;
      uint64_t word = 0;
      for (int b = 0; b < 8; b += 2) {
        const float d0 = static_cast<float>(origin[1] + b) - c.y, d1 = d0 + 1;
        const __m512 rr = _mm512_mask_blend_ps(0xFF00, _mm512_set1_ps(dx2 + d0 * d0),
                                               _mm512_set1_ps(dx2 + d1 * d1));
        __m512 s = _mm512_min_ps(_mm512_sub_ps(r, _mm512_sqrt_ps(_mm512_add_ps(rr, vz))), band);
        const __m512 v = _mm512_max_ps(_mm512_loadu_ps(values + a * 64 + b * 8), s);
        _mm512_storeu_ps(values + a * 64 + b * 8, v);
        min = _mm512_min_ps(min, v);
        const __mmask16 on =
            _mm512_cmp_ps_mask(v, band, _CMP_LT_OQ) & _mm512_cmp_ps_mask(v, minus, _CMP_GT_OQ);
        word |= static_cast<uint64_t>(on) << (b * 8);
      }
      active.getWord<uint64_t>(static_cast<openvdb::Index>(a)) = word;
      any |= word;
    }
    dead = !any && _mm512_reduce_min_ps(min) >= kBand;
#else
    float min = kBand;
    for (int a = 0; a < 8; a++) {
      uint64_t word = 0;
      for (int b = 0; b < 64; b++) {
        const float dx = static_cast<float>(origin[0] + a) - c.x, dy = static_cast<float>(origin[1] + b / 8) - c.y,
                    dz = static_cast<float>(origin[2] + b % 8) - c.z;
        const float v = std::max(values[a * 64 + b], std::min(kBand, radius - std::sqrt(dx * dx + dy * dy + dz * dz)));
        values[a * 64 + b] = v;
        min = std::min(min, v);
        word |= static_cast<uint64_t>(v < kBand && v > -kBand) << b;
      }
      active.getWord<uint64_t>(static_cast<openvdb::Index>(a)) = word;
      any |= word;
    }
    dead = !any && min >= kBand;
#endif
    if (dead) access.addTile(1, origin, kBand, false);
  });
}

void stamp_bitmask(MaskGrid::Accessor& access, Point c, float radius) {
  const float radius2 = radius * radius;
  for_leaves(c, radius, [&](const Coord& origin) {
    const Near d = leaf_distance(origin, c);
    if (d.min2 > radius2) return;
    auto* leaf = access.probeLeaf(origin);
    if (d.max2 <= radius2) {
      if (leaf || access.isValueOn(origin)) access.addTile(1, origin, false, false);
      return;
    }
    if (!leaf) {
      if (!access.isValueOn(origin)) return;
      leaf = access.touchLeaf(origin);
    }
    auto& active = const_cast<openvdb::MaskTree::LeafNodeType::NodeMaskType&>(leaf->getValueMask());
    uint64_t any = 0;
    float z2[8];
    for (int q = 0; q < 8; q++) {
      const float dz = static_cast<float>(origin[2] + q) - c.z;
      z2[q] = dz * dz;
    }
    for (int a = 0; a < 8; a++) {
      const float dx = static_cast<float>(origin[0] + a) - c.x, left = radius2 - dx * dx;
      uint64_t word = 0;
      for (int b = 0; b < 8; b++) {
        const float dy = static_cast<float>(origin[1] + b) - c.y, rest = left - dy * dy;
#if defined(__AVX512F__) && defined(__AVX512VL__)
        const __mmask8 in =
            _mm256_cmp_ps_mask(_mm256_loadu_ps(z2), _mm256_set1_ps(rest), _CMP_LE_OQ);
        word |= static_cast<uint64_t>(static_cast<uint8_t>(in)) << (b * 8);
#else
        for (int q = 0; q < 8; q++) word |= static_cast<uint64_t>(z2[q] <= rest) << (b * 8 + q);
#endif
      }
      uint64_t& bits = active.getWord<uint64_t>(static_cast<openvdb::Index>(a));
      bits &= ~word;
      any |= bits;
    }
    if (!any) access.addTile(1, origin, false, false);
  });
}

Point shifted(Point p) { return {p.x + kOffset, p.y + kOffset, p.z + kOffset}; }

template <class Body>
StepTimes timed(const std::vector<Point>& path, Body&& body) {
  StepTimes result;
  result.us.reserve(path.size());
  for (const Point& p : path) {
    const double start = now_us();
    body(shifted(p));
    result.us.push_back(now_us() - start);
  }
  return result;
}

double levelset_removed(const FloatGrid& grid, int n) {
  double count = 0;
  auto access = grid.getConstAccessor();
  for (int i = kOffset; i < kOffset + n; i++)
    for (int j = kOffset; j < kOffset + n; j++)
      for (int k = kOffset + n - 80; k < kOffset + n; k++)
        count += access.getValue(Coord(i, j, k)) >= 0 ? 1 : 0;
  return count;
}

}  // namespace

StepTimes openvdb_levelset_stamp(int n, const std::vector<Point>& path, float radius) {
  auto grid = solid_levelset(n);
  FloatGrid::Accessor access(grid->tree());
  StepTimes result = timed(path, [&](Point c) { stamp_levelset(access, c, radius); });
  result.bytes = static_cast<double>(grid->memUsage());
  result.removed = levelset_removed(*grid, n);
  return result;
}

StepTimes openvdb_bitmask_stamp(int n, const std::vector<Point>& path, float radius) {
  auto grid = MaskGrid::create();
  grid->tree().fill(openvdb::CoordBBox(Coord(kOffset), Coord(kOffset + n - 1)), true, true);
  MaskGrid::Accessor access(grid->tree());
  StepTimes result = timed(path, [&](Point c) { stamp_bitmask(access, c, radius); });
  result.bytes = static_cast<double>(grid->memUsage());
  result.removed = static_cast<double>(n) * n * n - static_cast<double>(grid->activeVoxelCount());
  return result;
}

StepTimes openvdb_csg_difference(int n, const std::vector<Point>& path, float radius) {
  openvdb::initialize();
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  auto grid = solid_levelset(n);
  StepTimes result = timed(path, [&](Point c) {
    auto ball = openvdb::tools::createLevelSetSphere<FloatGrid>(
        radius, openvdb::Vec3f(c.x, c.y, c.z), 1.f, kBand, false);
    openvdb::tools::csgDifference(*grid, *ball);
  });
  result.bytes = static_cast<double>(grid->memUsage());
  return result;
}

StepTimes openvdb_local_remesh(int n, const std::vector<Point>& path, float radius, int from,
                               double* triangles) {
  openvdb::initialize();
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  auto grid = solid_levelset(n);
  FloatGrid::Accessor access(grid->tree());
  StepTimes result;
  std::vector<double> counts;
  for (size_t i = 0; i < path.size(); i++) {
    const Point at = shifted(path[i]);
    stamp_levelset(access, at, radius);
    if (static_cast<int>(i) < from) continue;
    const double start = now_us();
    const auto around = FloatGrid::create(kBand);
    around->setGridClass(openvdb::GRID_LEVEL_SET);
    for_leaves(at, radius + kBand, [&](const Coord& origin) {
      if (const auto* leaf = access.probeConstLeaf(origin))
        around->tree().addLeaf(new openvdb::FloatTree::LeafNodeType(*leaf));
    });
    std::vector<openvdb::Vec3s> corners;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*around, corners, quads);
    result.us.push_back(now_us() - start);
    counts.push_back(2.0 * static_cast<double>(quads.size()));
  }
  *triangles = median(counts);
  return result;
}

MeshTimes openvdb_mesh_through_volume(const std::vector<float>& xyz,
                                      const std::vector<unsigned>& triangles, int n) {
  openvdb::initialize();
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<openvdb::Vec3s> points;
  openvdb::Vec3s low(1e30f), high(-1e30f);
  for (size_t i = 0; i + 2 < xyz.size(); i += 3) {
    points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
    for (int a = 0; a < 3; a++) {
      low[a] = std::min(low[a], points.back()[a]);
      high[a] = std::max(high[a], points.back()[a]);
    }
  }
  std::vector<openvdb::Vec3I> faces;
  for (size_t i = 0; i + 2 < triangles.size(); i += 3)
    faces.emplace_back(triangles[i], triangles[i + 1], triangles[i + 2]);
  const float longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  const auto transform =
      openvdb::math::Transform::createLinearTransform(static_cast<double>(longest) / n);
  const double start = now_us();
  const auto grid = openvdb::tools::meshToLevelSet<FloatGrid>(*transform, points, faces, kBand);
  MeshTimes times;
  times.in_ms = (now_us() - start) / 1000;
  std::vector<openvdb::Vec3s> corners;
  std::vector<openvdb::Vec4I> quads;
  const double out = now_us();
  openvdb::tools::volumeToMesh(*grid, corners, quads);
  times.out_ms = (now_us() - out) / 1000;
  times.triangles_out = 2 * quads.size();
  return times;
}

}  // namespace kibori_bench
