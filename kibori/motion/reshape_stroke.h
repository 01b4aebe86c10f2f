// SPDX-License-Identifier: MIT
// A reshaping stroke: converts the path of the tip into dabs, warps or presses and their force.
//
//   dabs    The first dab is where the stroke begins. The others follow at equal distances
//           (Brush::spacing). The same path gives the same dabs (up to rounding), for any
//           division of the path into ticks.
//           A snake hook pulls at each dab: from the place of the last dab to that of this one.
//           It has no dab at the beginning, and its first pull is straight.
//           A brush with a texture (alpha.h) has no dab at the beginning either, because the
//           texture needs the direction of the path.
//           If the brush follows the pressure of a pen, each dab has its own size and strength, and
//           its size gives the distance to the next one. Between two ticks the pressure is
//           interpolated. A snake hook follows it by its size only: with less strength, it would
//           lose the strand.
//   warps   The model is a function of its state at the stroke's beginning and of the hand's
//           displacement and turn since. It is recomputed at intervals and at the stroke's end.
//   press   The tool is swept exactly in every tick. The material that it displaces is pending. It
//           returns around the tool at equal distances of path. At the stroke's end, the rest
//           returns as far as there is room.
//   wheel   The material turns about a vertical axis. At equal distances of path, the tool changes
//           the profile (wheel.h). There are no images: the body is already symmetric.
//
// The force of a dab or press is its work divided by the distance to the next one. The force is
// held until the next one and acts against the motion:
//
//   energy, series   F = -u (added + removed) / spacing  v / max(|v|, v0)
//   paper            F = -Kf K |p| / spacing  p / |p|    K the nodes that changed sides
//
// Its moment is that of a force at the centre of the changed volume. A warp or a snake hook resists
// by a spring and a dashpot in series (MaxwellForce). In model `paper` they use eq. (4) with the
// nodes that changed sides.
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

// Below this speed [mm/s] the force of `energy` decreases in proportion to the speed.
inline constexpr double kFullForceSpeed = 5;

// Errors: those of check_brush, for the brush settings that the mode uses.
Status check_brush_of(Mode mode, const Brush& brush);

// Default strength of a mode. It is 1 for warps, snake hook, paint and mask: the surface stays at
// the hand, and paint covers fully. For other modes it is 0.5.
double default_strength(Mode mode);

// Replaces a mode that does not suit the stock. In a plastic stock (clay), `cut` becomes `press`
// and `turn` becomes `throw_clay`.
inline Mode mode_in(const Material& stock, Mode mode) {
  if (!stock.plastic) return mode;
  return mode == Mode::cut ? Mode::press : mode == Mode::turn ? Mode::throw_clay : mode;
}

// Radius of a tool's body about its axis [mm]. Finger: its radius 2 mm above the tip.
double tool_radius_mm(const Tool& tool);

// Distance around a tool within which displaced material returns [mm].
double press_radius_mm(const Tool& tool, double pitch_mm);

// Force of dabs with this work per mm, on a tool at that velocity. Below `full_speed_mm_s` it
// decreases in proportion to the speed, except in model `paper`.
Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s, double rate_hz,
                double full_speed_mm_s = kFullForceSpeed);

// A spring and a dashpot in series. It resists a pull, and its force decays. It is passive. One
// implicit step per tick: F = (F - k displacement) / (1 + dt / kRelaxS).
class MaxwellForce {
 public:
  // Time constant of the decay [s]: the force of a hand at rest falls to 37 % in this time. A
  // shorter time makes a pull hard to notice. With a longer one, it remains after half a second.
  static constexpr double kRelaxS = 0.15;

  void begin() { force_ = Vec3::Zero(); }
  Vec3 pull(double stiffness_n_mm, const Vec3& displacement_mm, double tick_s) {
    force_ = (force_ - stiffness_n_mm * displacement_mm) / (1 + tick_s / kRelaxS);
    return force_;
  }

 private:
  Vec3 force_ = Vec3::Zero();
};

// Settings of a reshaping stroke. They are constant during the stroke.
struct ReshapeSettings {
  Mode mode = Mode::smooth;
  Brush brush = {};
  Tool tool = BallTool{};  // of press
  ForceLaw law = {};
  double rate_hz = 1000;
  Symmetry symmetry = {};
  bool grows = false;  // the lattice grows if the stroke needs room; else its border cuts it off
};

// Working memory of dabs and of collars of clay. Its size depends on the brush. The first dab
// allocates it, and takes two to three times as long as the next dabs.
struct DabMemory {
  Reshaper reshaper;
  Clay clay;

  size_t bytes() const { return reshaper.kept_bytes() + clay.kept_bytes(); }
};

class ReshapeStroke {
 public:
  // Only one stroke at a time may use `memory`. A caller that makes many strokes should reuse it.
  explicit ReshapeStroke(TriDexel& model,
                         std::shared_ptr<DabMemory> memory = std::make_shared<DabMemory>())
      : model_(model), memory_(std::move(memory)), edit_(model), warp_(model), wheel_(model) {}

  // Number of threads for dabs, warps, presses and collars of clay. Results do not depend on it.
  void set_threads(int threads) {
    threads_ = threads;
    memory_->reshaper.set_threads(threads);
    memory_->clay.set_threads(threads);
    warp_.set_threads(threads);
  }
  // Begins a stroke with the tool at `start`. `materials`: not empty; must stay valid until the
  // next begin(). Errors: a mode that does not reshape; a brush that check_brush_of rejects.
  Status begin(const ReshapeSettings& settings, const std::vector<Material>& materials,
               const Pose& start);
  // Call this after the tool moved to tick.pose and turned by tick.motion.turn. Writes the result
  // and the wrench to `tick`. `now`: computes a warp in this tick even if the hand hardly moved.
  // Errors: those of Reshaper::dab and Warp::warp; more than kMaxDabs dabs in one tick.
  Status advance(ToolTick& tick, bool now = false);
  // Ends the stroke at the last tick's pose. Computes a warp there. Returns the pending material of
  // a press as far as there is room. Adds the result to `tick`.
  Status end(ToolTick& tick);
  // Ends an interrupted stroke. Computes a warp at the last tick's pose; returns no material.
  Status break_off();

  // Resistance of the last dabs or presses (see held_force).
  double work_per_mm() const { return held_.work_per_mm; }
  // Stiffness of the pull of a warp or snake hook [N/mm]: see MaxwellForce.
  double stiffness_n_mm() const { return stiffness_n_mm_; }
  // Pressed material that has not returned [mm^3]. After end(), it is that which found no room.
  double pending_mm3() const { return pending_mm3_; }
  // True if the result depends on the pose of begin() and the current pose, but not on the path
  // between them: a warp, or a snake hook that has not pulled yet.
  bool holds_start() const {
    return warps(settings_.mode) || (settings_.mode == Mode::snake_hook && !has_dab_);
  }

  static constexpr double kMaxDabs = 10000;

 private:
  // Resistance of the last dabs, per mm of path: energy u (added + removed) [N], or in model
  // `paper` Kf K [N/mm].
  struct Held {
    double work_per_mm = 0;
    Vec3 lever = Vec3::Zero();  // work_per_mm times its centre, relative to the dab [mm]
  };
  // Sums over one tick.
  struct Sums {
    double added = 0, removed = 0;
    int64_t points = 0;
    Held held;
    int dabs = 0;
    bool clipped = false;
  };

  double spacing_mm() const;
  void press_brush(double pressure);
  Result<Reshaped> dab_with_room(FieldVerb verb, const Brush& brush,
                                 const std::vector<DabPlace>& places, double missed_mm3 = 0);
  Status dab(const Vec3& centre, Sums& sums);
  // Crease, warps and the wheel have no texture.
  bool has_texture() const {
    return settings_.brush.alpha != Alpha::none && dabs(settings_.mode) &&
           settings_.mode != Mode::crease && settings_.mode != Mode::snake_hook;
  }
  AlphaFrame alpha_frame(const Vec3& centre);
  Status crease(const Vec3& centre, Sums& sums);
  Status hook(const Vec3& centre, Sums& sums);
  void hold(const Reshaped& what, const Vec3& centre, Sums& sums) const;
  Status press(const ToolMotion& motion, const Pose& end, Sums& sums);
  Status press_along(const ToolMotion& motion, const Pose& end, Sums& sums);
  Status give_back(double until, double left, double wider, Sums& sums);
  Status compute_warp(Sums& sums);
  Status turn_to(const Pose& end, Sums& sums);
  std::vector<Drag> drags() const;
  std::vector<Drag> with_images(const Drag& drag) const;
  void finish_tick(const Sums& sums, const Vec3& displacement, ToolTick& tick);
  const Material& material(int i) const { return material_of(*materials_, i); }

  TriDexel& model_;
  std::shared_ptr<DabMemory> memory_;
  ToolEdit edit_;
  int threads_ = 1;
  Warp warp_;
  Wheel wheel_;
  ReshapeSettings settings_;
  Brush brush_;  // of the current dab: that of the settings, changed by the pen's pressure
  const std::vector<Material>* materials_ = nullptr;
  SymmetryImages images_;
  Pose start_, last_;
  Held held_;
  // State of dabs and presses.
  double to_next_mm_ = 0;           // distance of path to the next one
  bool has_dab_ = false;            // since begin()
  std::optional<double> pressure_;  // at the end of the last tick
  Vec3 hooked_mm_ = Vec3::Zero();   // snake hook: the place of the last dab
  // Texture: the point that trails behind the tip, and the offset (AlphaFrame::shift) at the next
  // dab.
  Vec3 trail_ = Vec3::Zero();
  double shift_ = 0;
  std::optional<FlatPlane> plane_;
  // Press: the pending volume, and the total pressed volume.
  double pending_mm3_ = 0, pressed_mm3_ = 0;
  double missed_mm3_ = 0;  // smooth with keep_volume: removed minus added volume of the dabs so far
  // Press: centre of the volume that was pressed last, and direction of that motion.
  Vec3 middle_ = Vec3::Zero(), direction_ = Vec3::Zero();
  Pose met_;  // wheel: pose at which the profile last met the tool
  // State of a warp.
  double turn_rad_ = 0;
  Vec3 normal_ = Vec3::UnitZ();
  uint8_t material_ = 0;
  double stiffness_n_mm_ = 0;
  MaxwellForce pull_;
  bool computed_ = true;  // the model matches the last pose
  Pose computed_at_;      // pose of the last computation
  double computed_turn_rad_ = 0;
  Reshaped warped_;  // last computed result, relative to the stroke's beginning
};

}  // namespace kibori
