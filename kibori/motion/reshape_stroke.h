// SPDX-License-Identifier: MIT
// A stroke that reshapes the model. It converts the path of the tip into changes of the model, and
// computes their force. There are four kinds:
//
//   dabs    The first dab is where the stroke begins. The others follow at equal distances
//           (Brush::spacing). If a path is divided into other ticks, the dabs are the same, except
//           for rounding errors.
//           A snake hook is a dab that pulls the surface from the place of the last dab to its own
//           place. It has no dab where the stroke begins, and its first pull is straight.
//           A brush with a texture (alpha.h) has no dab there either, because the texture needs the
//           direction of the path.
//           If the brush follows the pressure of a pen, each dab has its own size and strength. Its
//           size gives the distance to the next dab. Between two ticks, the pressure is
//           interpolated. For a snake hook, only the size follows the pressure: with less
//           strength, the hook would lose the strand.
//   warps   The model is a function of its state at the stroke's beginning, and of the hand's
//           displacement and turn since then. The warp is computed at intervals and at the
//           stroke's end.
//   press   In every tick, the tool removes exactly the material that it sweeps. This material is
//           pending. It returns around the tool at equal distances of path. At the stroke's end,
//           the rest returns as far as there is room.
//   wheel   The material turns about a vertical axis. At equal distances of path, the tool changes
//           the profile (wheel.h). There are no images, because the body is already symmetric.
//
// The force of a dab or a press is its work divided by the distance to the next one. This force
// stays until the next dab or press, and acts against the motion with the velocity v:
//
//   energy, series   F = -u (added + removed) / spacing  v / max(|v|, v0)
//   paper            F = -Kf K |p| / spacing  p / |p|    K: number of nodes that changed sides,
//                                                        p: displacement of the tip in the tick
//
// The moment is that of a force at the centre of the changed volume. A warp or a snake hook resists
// like a spring and a dashpot in series (MaxwellForce). In the model `paper`, it resists as in eq.
// (4) of the paper, with the nodes that changed sides.
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

// Below this speed v0 [mm/s], the force of `energy` and `series` decreases in proportion to the
// speed.
inline constexpr double kFullForceSpeed = 5;

// Returns Ok if check_brush accepts the brush for this mode. Otherwise, returns the error sentence.
Status check_brush_of(Mode mode, const Brush& brush);

// Returns the default strength of a mode. It is 1 for warps, snake hook, paint and mask: the
// surface stays at the hand, and paint covers fully. For other modes, it is 0.5.
double default_strength(Mode mode);

// Returns the mode for this stock. In a plastic stock (clay), `cut` becomes `press`, and `turn`
// becomes `throw_clay`. All other modes stay.
inline Mode mode_in(const Material& stock, Mode mode) {
  if (!stock.plastic) return mode;
  return mode == Mode::cut ? Mode::press : mode == Mode::turn ? Mode::throw_clay : mode;
}

// Returns the radius of a tool's body about its axis [mm]. For a finger: the radius 2 mm above the
// tip.
double tool_radius_mm(const Tool& tool);

// Returns the distance around a tool within which displaced material returns [mm].
double press_radius_mm(const Tool& tool, double pitch_mm);

// Returns the force of dabs on a tool with this velocity. `work_per_mm` is the work of the dabs per
// mm of path. Below `full_speed_mm_s`, the force decreases in proportion to the speed. In the model
// `paper`, it is always proportional to the speed.
Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s, double rate_hz,
                double full_speed_mm_s = kFullForceSpeed);

// A spring and a dashpot in series. It resists a pull, and its force decays. It is passive. Each
// tick is one implicit step: F = (F - k displacement) / (1 + dt / kRelaxS).
class MaxwellForce {
 public:
  // Time constant of the decay [s]. If the hand rests, the force falls to 37 % in this time. With a
  // shorter time, a pull is hard to notice. With a longer time, the force remains after half a
  // second.
  static constexpr double kRelaxS = 0.15;

  void begin() { force_ = Vec3::Zero(); }
  Vec3 pull(double stiffness_n_mm, const Vec3& displacement_mm, double tick_s) {
    force_ = (force_ - stiffness_n_mm * displacement_mm) / (1 + tick_s / kRelaxS);
    return force_;
  }

 private:
  Vec3 force_ = Vec3::Zero();
};

// Settings of a reshaping stroke. They do not change during the stroke.
struct ReshapeSettings {
  Mode mode = Mode::smooth;
  Brush brush = {};
  Tool tool = BallTool{};  // for press and the wheel
  ForceLaw law = {};
  double rate_hz = 1000;
  Symmetry symmetry = {};
  bool grows = false;  // the lattice grows when the stroke needs room; else its border cuts
};

// Working memory of dabs and of collars of clay. Its size depends on the brush. The first dab
// allocates it. Therefore, this dab takes two to three times as long as the next ones.
struct DabMemory {
  Reshaper reshaper;
  Clay clay;

  size_t bytes() const { return reshaper.kept_bytes() + clay.kept_bytes(); }
};

class ReshapeStroke {
 public:
  // Only one stroke at a time may use `memory`. A caller that makes many strokes should pass the
  // same memory to all.
  explicit ReshapeStroke(TriDexel& model,
                         std::shared_ptr<DabMemory> memory = std::make_shared<DabMemory>())
      : model_(model), memory_(std::move(memory)), edit_(model), warp_(model), wheel_(model) {}

  // Sets the number of threads for dabs, warps, presses and collars of clay. It does not change the
  // result.
  void set_threads(int threads) {
    threads_ = threads;
    memory_->reshaper.set_threads(threads);
    memory_->clay.set_threads(threads);
    warp_.set_threads(threads);
  }
  // Begins a stroke with the tool at `start`. `materials` must not be empty, and must stay valid
  // until the next begin(). Errors: the mode does not reshape; check_brush_of rejects the brush.
  Status begin(const ReshapeSettings& settings, const std::vector<Material>& materials,
               const Pose& start);
  // Call this after the tool moved to tick.pose and turned by tick.motion.turn. Writes the result
  // and the wrench to `tick`. If `now` is true, a warp is computed even if the hand hardly moved.
  // Errors: those of the dab, warp, collar or wheel; the tick needs more than kMaxDabs dabs; the
  // motion needs more than kMaxTurnSubsteps substeps.
  Status advance(ToolTick& tick, bool now = false);
  // Ends the stroke at the pose of the last tick. Computes a warp, changes the profile on the
  // wheel, or returns the pending material of a press as far as there is room. Adds the result to
  // `tick`.
  Status end(ToolTick& tick);
  // Ends an interrupted stroke. Computes a warp at the pose of the last tick. Returns no material.
  Status break_off();

  // Returns the resistance of the last dabs or presses (see held_force).
  double work_per_mm() const { return held_.work_per_mm; }
  // Returns the stiffness of the pull of a warp or a snake hook [N/mm]: see MaxwellForce.
  double stiffness_n_mm() const { return stiffness_n_mm_; }
  // Returns the volume of pressed material that has not returned [mm^3]. After end(), this volume
  // has found no room.
  double pending_mm3() const { return pending_mm3_; }
  // Returns true if the result depends on the pose of begin() and the current pose, but not on the
  // path between them. This is so for a warp, and for a brush whose first dab comes only after
  // some path: it follows the path's direction.
  bool holds_start() const { return warps(settings_.mode) || (needs_direction() && !has_dab_); }

  static constexpr double kMaxDabs = 10000;

 private:
  // Resistance of the last dabs, per mm of path: in the model `paper` Kf K [N/mm], otherwise u
  // (added + removed) [N].
  struct Held {
    double work_per_mm = 0;
    Vec3 lever = Vec3::Zero();  // work_per_mm times the work's centre, relative to the dab [mm]
  };
  // The sums over one tick.
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
  // Returns true if dabs of this stroke have a texture. Crease, snake hook, warps and the wheel
  // have none.
  bool has_texture() const {
    return settings_.brush.alpha != Alpha::none && dabs(settings_.mode) &&
           settings_.mode != Mode::crease && settings_.mode != Mode::snake_hook;
  }
  // True if a dab depends on the direction of the path before it.
  bool needs_direction() const { return settings_.mode == Mode::snake_hook || has_texture(); }
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
  Brush brush_;  // brush of the current dab: the settings, changed by the pen's pressure
  const std::vector<Material>* materials_ = nullptr;
  SymmetryImages images_;
  Pose start_, last_;
  Held held_;
  // State of dabs and presses.
  double to_next_mm_ = 0;           // distance of path to the next dab or press
  bool has_dab_ = false;            // true if there was a dab since begin()
  std::optional<double> pressure_;  // pressure at the end of the last tick
  Vec3 hooked_mm_ = Vec3::Zero();   // snake hook: place of the last dab
  // Texture: a point that trails behind the tip; AlphaFrame::shift of the next dab.
  Vec3 trail_ = Vec3::Zero();
  double shift_ = 0;
  std::optional<FlatPlane> plane_;
  // Press: the pending volume, and the sum of all pressed volumes.
  double pending_mm3_ = 0, pressed_mm3_ = 0;
  double missed_mm3_ = 0;  // smooth with keep_volume: removed minus added volume, so far
  // Press: centre of the last volume that was pressed, and the direction of that motion.
  Vec3 middle_ = Vec3::Zero(), direction_ = Vec3::Zero();
  Pose met_;  // wheel: pose at which the tool last changed the profile
  // State of a warp.
  double turn_rad_ = 0;
  Vec3 normal_ = Vec3::UnitZ();
  uint8_t material_ = 0;
  double stiffness_n_mm_ = 0;
  MaxwellForce pull_;
  bool computed_ = true;  // true if the model matches the last pose
  Pose computed_at_;      // pose of the last computation
  double computed_turn_rad_ = 0;
  Reshaped warped_;  // result of the last computation, relative to the stroke's beginning
};

}  // namespace kibori
