// SPDX-License-Identifier: MIT
// A reshaping stroke: what a brush or a pressing tool makes of the tip's way, and the force of it.
//
//   dabs    The first lies where the stroke begins, the others at equal lengths of way, a quarter
//   of
//           the brush's radius apart: the same way gives the same dabs (but for rounding), whatever
//           the ticks.
//   warps   The model is a function of what it was when the stroke began, and of the hand's way and
//           turn since. It is computed now and then, and always where the stroke ends.
//   press   The tool is swept exactly, tick by tick. What it pushes away is owed, and comes back
//           around the tool at equal lengths of way; at the stroke's end, all of it that has room.
//   wheel   The material turns about a vertical axis, and the tool is swept at equal lengths of way
//           against its profile: see wheel.h. There are no images: all around is one already.
//
// The force of a dab or press is its work over the way to the next one, held until then and against
// the motion:
//
//   energy, series   F = -u (added + removed) / spacing  v / max(|v|, v0)
//   paper            F = -Kf K |p| / spacing  p / |p|    K the nodes that changed sides
//
// Its moment is that of a force at the middle of what moved. A warp pulls by a spring and a dashpot
// in series: see MaxwellForce; with `paper`, by eq. (4) of the nodes that changed sides.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/symmetry.h>
#include <kibori/motion/tool_edit.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/reshape/clay.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/reshape/warp.h>
#include <kibori/reshape/wheel.h>

namespace kibori {

// Below this speed [mm/s], the force of `energy` fades with it.
inline constexpr double kFullForceSpeed = 5;

// Errors: those of check_brush, by what the mode takes.
Status check_brush_of(Mode mode, const Brush& brush);

// The strength that a person expects where none is chosen: a warp's surface stays at the hand, and
// paint covers.
double default_strength(Mode mode);

// What a tool that cuts, or that cuts what turns, does in a stock of that material: clay is
// pressed, and thrown.
inline Mode mode_in(const Material& stock, Mode mode) {
  if (!stock.plastic) return mode;
  return mode == Mode::cut ? Mode::press : mode == Mode::turn ? Mode::throw_clay : mode;
}

// How far a tool's body goes from its axis [mm]; a finger's, 2 mm above its tip.
double tool_radius_mm(const Tool& tool);

// How far around a tool the material that it presses away comes back [mm].
double press_radius_mm(const Tool& tool, double pitch_mm);

// The force that dabs of so much work ask of a tool at that speed. Below `full_speed_mm_s` it fades
// with the speed, but for `paper`.
Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s, double rate_hz,
                double full_speed_mm_s = kFullForceSpeed);

// A spring and a dashpot in series: it resists a pull, gives way within kRelaxS, and is passive. By
// one implicit step a tick: F = (F - k way) / (1 + dt / kRelaxS).
class MaxwellForce {
 public:
  // What a hand feels of a warp decays to a third in this time [s]: long enough that a pull is felt
  // as one, short enough that a hand that holds still holds nothing after half a second.
  static constexpr double kRelaxS = 0.15;

  void begin() { force_ = Vec3::Zero(); }
  Vec3 pull(double stiffness_n_mm, const Vec3& way_mm, double tick_s) {
    force_ = (force_ - stiffness_n_mm * way_mm) / (1 + tick_s / kRelaxS);
    return force_;
  }

 private:
  Vec3 force_ = Vec3::Zero();
};

// What a reshaping stroke is made with, from its beginning to its end.
struct ReshapeSettings {
  Mode mode = Mode::smooth;
  Brush brush = {};
  Tool tool = BallTool{};  // of press
  ForceLaw law = {};
  double rate_hz = 1000;
  Symmetry symmetry = {};
};

// What dabs and collars of clay are computed in: memory of a brush's size, which the first of them
// takes from the system, two to three times as slowly as the next ones run.
struct DabMemory {
  Reshaper reshaper;
  Clay clay;

  size_t bytes() const { return reshaper.kept_bytes() + clay.kept_bytes(); }
};

class ReshapeStroke {
 public:
  // `memory`: for one stroke at a time; whoever makes many keeps it.
  explicit ReshapeStroke(TriDexel& model,
                         std::shared_ptr<DabMemory> memory = std::make_shared<DabMemory>())
      : model_(model), memory_(std::move(memory)), edit_(model), warp_(model), wheel_(model) {}

  // On how many threads dabs, warps, presses and collars of clay run; results do not depend on it.
  void set_threads(int threads) {
    threads_ = threads;
    memory_->reshaper.set_threads(threads);
    memory_->clay.set_threads(threads);
    warp_.set_threads(threads);
  }
  // A stroke begins with the tool at `start`. `materials`: not empty, and there until the next
  // begin(). Errors: a mode that does not reshape, a brush that check_brush_of refuses.
  Status begin(const ReshapeSettings& settings, const std::vector<Material>& materials,
               const Pose& start);
  // The tool went to tick.pose, and turned by tick.motion.turn: into `tick` what came of it, and
  // the wrench. `now`: a warp is computed in this tick, however little the hand moved. Errors:
  // those of Reshaper::dab and Warp::warp; more than kMaxDabs in one tick.
  Status advance(ToolTick& tick, bool now = false);
  // The stroke is over, where the last tick ended: a warp is computed there, and what is owed of a
  // press comes back as far as there is room. Into `tick` what came of it.
  Status end(ToolTick& tick);
  // A stroke that is broken off: a warp is computed where the last tick ended.
  Status break_off();

  // What the last dabs or presses ask: see held_force; of a warp, its spring [N/mm].
  double work_per_mm() const { return held_.work_per_mm; }
  double stiffness_n_mm() const { return stiffness_n_mm_; }
  // What a press could not give back, for want of room [mm^3].
  double owed_mm3() const { return owed_mm3_; }

  static constexpr double kMaxDabs = 10000;

 private:
  // Of the last dabs, per mm of way: energy u (added + removed) [N], or of `paper` Kf K [N/mm].
  struct Held {
    double work_per_mm = 0;
    Vec3 lever = Vec3::Zero();  // work_per_mm times where it lies, from the dab's place [mm]
  };
  // Sums of a tick.
  struct Sums {
    double added = 0, removed = 0;
    int64_t points = 0;
    Held held;
    int dabs = 0;
    bool clipped = false;
  };

  double spacing_mm() const;
  Status dab(const Vec3& centre, Sums& sums);
  Status crease(const Vec3& centre, Sums& sums);
  void hold(const Reshaped& what, const Vec3& centre, Sums& sums) const;
  Status press(const ToolMotion& motion, const Pose& end, Sums& sums);
  Status press_along(const ToolMotion& motion, const Pose& end, Sums& sums);
  Status give_back(double until, double left, double wider, Sums& sums);
  Status compute_warp(Sums& sums);
  Status turn_to(const Pose& end, Sums& sums);
  std::vector<Drag> drags() const;
  void finish_tick(const Sums& sums, const Vec3& way, ToolTick& tick);
  const Material& material(int i) const { return material_of(*materials_, i); }

  TriDexel& model_;
  std::shared_ptr<DabMemory> memory_;
  ToolEdit edit_;
  int threads_ = 1;
  Warp warp_;
  Wheel wheel_;
  ReshapeSettings settings_;
  const std::vector<Material>* materials_ = nullptr;
  SymmetryImages images_;
  Pose start_, last_;
  Held held_;
  // Of dabs and presses.
  double to_next_mm_ = 0;  // of way, until the next one
  std::optional<FlatPlane> plane_;
  // Of a press: what is not back yet, what was pressed away in all, where last, and which way.
  double owed_mm3_ = 0, pressed_mm3_ = 0;
  double missed_mm3_ = 0;  // by the dabs yet, of a volume that is kept
  Vec3 middle_ = Vec3::Zero(), direction_ = Vec3::Zero();
  Pose met_;  // of a wheel: where the profile met the tool last
  // Of a warp.
  double turn_rad_ = 0;
  Vec3 normal_ = Vec3::UnitZ();
  uint8_t material_ = 0;
  double stiffness_n_mm_ = 0;
  MaxwellForce pull_;
  bool computed_ = true;  // the model is what the last pose asks
  Pose computed_at_;      // where it was computed last
  double computed_turn_rad_ = 0;
  Reshaped warped_;  // since the stroke's beginning, as it was computed last
};

}  // namespace kibori
