// SPDX-License-Identifier: MIT
// A reshaping stroke: where its dabs lie on the tip's way, and the force that they make.
//
// The first dab lies where the stroke begins, the others at equal lengths of way, a quarter of the
// brush's radius apart: so the same way gives the same dabs (but for rounding), whatever the ticks.
// The force of a dab is its work over that spacing, held until the next one and against the motion:
//
//   energy, series   F = -u (added + removed) / spacing  v / max(|v|, v0)
//   paper            F = -Kf K |p| / spacing  p / |p|    K the nodes that changed sides
//
// Its moment is that of a force at the middle of what moved.
#pragma once

#include <optional>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/reshape/reshaper.h>

namespace kibori {

// Of a mode that reshapes.
FieldVerb verb_of(Mode mode);

// Between dabs, of the brush's radius.
inline constexpr double kDabSpacing = 0.25;
// Below this speed [mm/s], the force of `energy` fades with it.
inline constexpr double kFullForceSpeed = 5;

// The force that dabs of so much work ask of a tool at that speed.
Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s, double rate_hz);

class DabStroke {
 public:
  explicit DabStroke(TriDexel& model) : model_(model) {}

  // A stroke begins at `tip_mm`: its first dab lies there.
  void begin(const Vec3& tip_mm);
  // The dabs on the way to where `tick` ended, and into `tick` what they did and the wrench.
  // Errors: `mode` does not reshape; those of Reshaper::dab; more than kMaxDabs in one tick.
  Status advance(Mode mode, const Brush& brush, const ForceLaw& law,
                 const std::vector<Material>& materials, double rate_hz, ToolTick& tick);

  // What the last dabs ask: see held_force.
  double work_per_mm() const { return held_.work_per_mm; }

  static constexpr double kMaxDabs = 10000;

 private:
  // Of the last dabs, per mm of way: energy u (added + removed) [N], or of `paper` Kf K [N/mm].
  struct Held {
    double work_per_mm = 0;
    Vec3 lever = Vec3::Zero();  // work_per_mm times where it lies, from the dab's place [mm]
  };

  TriDexel& model_;
  Reshaper reshaper_;
  Vec3 last_ = Vec3::Zero();
  double to_next_mm_ = 0;  // of way, until the next dab
  std::optional<FlatPlane> plane_;
  Held held_;
};

}  // namespace kibori
