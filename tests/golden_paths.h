// SPDX-License-Identifier: MIT
// Paths as a script carves them (Workpiece), and their required results. The results are the same
// on every vector unit, with every number of threads, and from Python. tests/test_python.py does
// the same with the module, and reads the numbers here. A change of the numbers is a change of
// results: document it in CHANGELOG.md.
#pragma once

#include <Eigen/Geometry>

#include <kibori/run/workpiece.h>

#include "tests/golden_session.h"

namespace kibori::test {

struct PathsOutcome {
  uint64_t hash = 0;  // of the model
  // Over all ticks, in order: the removed volume, and the absolute value of the largest component
  // of each force.
  double removed_mm3 = 0, force_n = 0;
};
inline constexpr PathsOutcome kGoldenPaths{0x393e42637201805a, 0x1.a24e63ce85b4ep+11,
                                           0x1.85e670bcbe6cdp+4};

inline PathsOutcome golden_paths(int threads) {
  Sequence sequence;
  Material a, b;
  a.name = "a";
  a.u = 0.002;
  b.name = "b";
  b.u = 0.007;
  Stock stock;
  stock.shape = StockBlock{Vec3(40, 32, 24)};
  stock.pitch_mm = 0.5;
  stock.room_mm = 4;
  const auto piece = std::move(Workpiece::make(stock, {a, b}, threads)).value();
  const Tool tools[] = {BallTool{3},     Flat{2, 12},     Bull{3, 1, 12},
                        Cone{50, 3, 14}, Capsule{1.5, 9}, Ellipsoid{Vec3(3, 2, 4)}};
  piece->set_grows(false);  // kGoldenPaths is for a lattice that cuts off deposits at its border
  PathsOutcome outcome;
  for (int i = 0; i < 200; i++) {
    StrokeSettings settings;
    settings.tool = tools[i % 6];
    settings.mode = i % 7 == 3 ? Mode::deposit : i % 11 == 5 ? Mode::touch : Mode::cut;
    settings.material = static_cast<uint8_t>(settings.mode == Mode::deposit);
    settings.force.law.model = i % 3 ? ForceModel::energy : ForceModel::paper;
    Pose pose;
    pose.tip = Vec3(20, 16, 22) + sequence.in_box(-1, 1).cwiseProduct(Vec3(19, 15, 5));
    // One at a time: compilers differ in the evaluation order of arguments.
    const Vec3 xyz = sequence.in_box(-0.3, 0.3);
    const double w = std::sqrt(1 - xyz.squaredNorm());
    pose.frame = Eigen::Quaterniond(w, xyz.x(), xyz.y(), xyz.z()).normalized().toRotationMatrix();
    if (!piece->begin(settings, pose)) return {};
    ToolTick last;
    for (int k = 2 + i % 4; k > 0; k--) {
      pose.tip += sequence.in_box(-0.6, 0.6);
      const Result<ToolTick> tick = piece->advance(pose);
      if (!tick) return {};
      last = tick.value();
      outcome.removed_mm3 += last.removed_mm3;
      outcome.force_n += last.wrench.force.cwiseAbs().maxCoeff();
    }
    if (!piece->end(&last)) return {};
  }
  outcome.hash = piece->model().content_hash();
  return outcome;
}

}  // namespace kibori::test
