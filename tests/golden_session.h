// SPDX-License-Identifier: MIT
// A session of 1000 strokes with ten of the tools, and its required hash: on every compiler,
// optimisation level, vector unit and number of threads. A change of the hash is a change of
// results: document it in CHANGELOG.md.
#pragma once

#include <algorithm>
#include <memory>

#include <kibori/base/hash.h>
#include <kibori/edit/scan_convert.h>
#include <kibori/motion/direct_tool.h>

#include "tests/plain_material.h"

namespace kibori::test {

struct GoldenHashes {
  uint64_t geometry;  // of the model
  uint64_t sums;      // of all forces and removed volumes
  bool operator==(const GoldenHashes&) const = default;
};
inline constexpr GoldenHashes kGolden{0x7c4be5faf469c786, 0x81c2613c015d2969};

// A sequence of pseudorandom numbers that does not depend on the C++ library.
class Sequence {
 public:
  double uniform(double low, double high) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (static_cast<double>(state_ >> 11) / 9007199254740992.0);
  }
  int below(int n) { return static_cast<int>(uniform(0, n)); }
  Vec3 in_box(double low, double high) {
    const double x = uniform(low, high), y = uniform(low, high);
    return {x, y, uniform(low, high)};
  }

 private:
  uint64_t state_ = 20261120;
};

// Hash of the model, of every wrench and of every removed volume.
inline GoldenHashes golden_session(int threads) {
  Sequence sequence;
  const Vec3 size(40, 32, 24);
  TriDexel model(make_lattice(size, 0.5, 4).value());
  model.fill_block({Vec3::Zero(), size}, 0);
  const std::vector<Material> materials{plain_material("a", 0.001, 2),
                                        plain_material("b", 0.003, 7)};

  auto mesh = std::make_shared<TriangleMesh>();
  mesh->vertices = {{0, 0, 0}, {3, 0, 1}, {0, 3, 2}, {1, 1, 4}};
  mesh->triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const Tool tools[] = {
      Finger{0.3, 20},          BallTool{3},     Flat{2, 12}, Bull{3, 1, 12},
      Cone{50, 3, 14},          Capsule{1.5, 9}, HalfSpace{}, BoxTool{Vec3(4, 3, 5)},
      Ellipsoid{Vec3(3, 2, 4)}, MeshTool{mesh}};
  Hash geometry, sums;
  const Snapshot start = model.snapshot();
  for (int stroke_index = 0; stroke_index < 1000; stroke_index++) {
    const int kind = sequence.below(60);
    const Tool& tool = tools[kind < 50 ? kind % 6 : kind == 50 ? 9 : 7 + kind % 2];
    const Vec3 target = Vec3(20, 16, 22) + sequence.in_box(-1, 1).cwiseProduct(Vec3(19, 15, 5));
    // One at a time: compilers differ in the evaluation order of arguments.
    const Vec3 axis = sequence.in_box(-1, 1) + Vec3(0, 0, 1.2);
    const double roll = sequence.uniform(-3, 3);
    DirectTool stroke(model, Pose{target, frame_from_axis(axis, roll)});
    stroke.set_threads(threads);
    const Mode mode = kind % 7 == 3 ? Mode::deposit : kind % 11 == 5 ? Mode::touch : Mode::cut;
    const ForceLaw law{kind % 2 ? ForceModel::energy : ForceModel::paper, kind % 3 ? 5 : 6};
    Vec3 at = target;
    const int ticks = 2 + sequence.below(4);
    for (int i = 0; i < ticks; i++) {
      at += sequence.in_box(-0.6, 0.6);
      const Vec3 turn =
          sequence.below(4) == 0 ? Vec3(0.05 * sequence.in_box(-1, 1)) : Vec3(Vec3::Zero());
      const auto tick = stroke.advance(tool, at, turn, mode, law, materials,
                                       static_cast<uint8_t>(stroke_index % 2));
      for (int a = 0; a < 3; a++) {
        sums.add(tick.value().wrench.force[a]);
        sums.add(tick.value().wrench.moment[a]);
      }
      sums.add(tick.value().removed_mm3);
    }
    if (stroke_index % 97 == 50) {
      Removed painted;
      EditOptions options;
      options.threads = threads;
      paint(model,
            SweptBall(LatticePoint{model.lattice().to_lattice(target)},
                      LatticeVector{Vec3(1, 2, 3)}, 9),
            0xff3366ffu, options, painted);
    }
    // Once, a half-space trims the model. Later, an intersection keeps only part of it.
    if (stroke_index == 400) {
      DirectTool trim(model, Pose{Vec3(20, 16, 25.3), frame_from_axis(Vec3(0.1, 0.2, 1))});
      trim.set_threads(threads);
      sums.add(trim.advance(tools[6], Vec3(20, 16, 25), Vec3::Zero(), Mode::cut, law, materials)
                   .value()
                   .removed_mm3);
    }
    if (stroke_index == 800) {
      Removed removed;
      EditOptions options;
      options.threads = threads;
      intersect(model, SweptBall(LatticePoint{Vec3(48, 40, 30)}, LatticeVector{Vec3(3, -2, 1)}, 45),
                options, removed);
      sums.add(removed.volume());
    }
  }
  geometry.add(model.content_hash());

  TriDexel scanned(make_lattice(Vec3(10, 10, 10), 0.25, 1).value());
  TriangleMesh soup;
  for (int i = 0; i < 12; i++) soup.vertices.push_back(sequence.in_box(0.5, 9.5));
  for (int i = 0; i < 6; i++) {
    uint32_t v[4];
    for (uint32_t& x : v) x = static_cast<uint32_t>(sequence.below(12));
    soup.triangles.push_back({v[0], v[2], v[1]});
    soup.triangles.push_back({v[0], v[1], v[3]});
    soup.triangles.push_back({v[1], v[2], v[3]});
    soup.triangles.push_back({v[2], v[0], v[3]});
  }
  if (scan_convert(scanned, soup, 1, {true, threads}).ok()) geometry.add(scanned.content_hash());
  return {geometry.value(), sums.value()};
}

}  // namespace kibori::test
