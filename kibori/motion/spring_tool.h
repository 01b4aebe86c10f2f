// SPDX-License-Identifier: MIT
// Force model `series`: the hand holds a spring, the spring holds the tool.
//
//   device x_d ──/\/\/\── tool x_p ──▶ material          F = -k (x_d - x_p), M = -kt theta
//
// In each tick the tool moves towards the device by the d in [0, L] that satisfies
//
//   k (L - d) = yield + u dV(d)/d + c dV(d)/T            (smallest root)
//
// dV(d) is the volume that the tool would newly reach. yield, u and c are means of the materials
// over that volume. The law of haptics/chip.h gives u.
//
// dV(d)/d is the sum of two parts. The first one is measured by lengths of rays, because they grow
// evenly with d. But they underestimate thin cuts. So the second part is a correction: how much the
// volumes of the cuts exceeded their lengths, as a mean over the last cell of path
// (haptics/path_mean.h). This mean lags by about half a cell. The lag does not violate passivity:
// the tool only moves towards the device, so the spring releases energy for any value of the force.
//
// If the spring pulls with less than the yield force, nothing is cut. The tool stops where it
// touches, and slides there against Coulomb friction. With a torsional spring, displacement and
// turn are one motion of length L^2 = |x_d - x_p|^2 + (kt/k) |theta|^2.
//
// The effective stiffness never exceeds k, for any material. So stability is one inequality (see
// haptics/safety.h).
//
// A hand also has a strength S: it pulls with min(S, k L). If S cannot drive the tool along its
// whole path, the tool cuts less deep. It follows the hand sideways, at the largest depth that S
// permits.
//
//   hand   ────────────────▶   wanted: 2 mm deep
//   tool  ──╲________________   what S permits in this wood: 1.4 mm
#pragma once

#include <optional>
#include <vector>

#include <kibori/base/field_info.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/haptics/chip.h>
#include <kibori/haptics/force.h>
#include <kibori/haptics/path_mean.h>
#include <kibori/motion/substeps.h>
#include <kibori/motion/tool_edit.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/solid/tool.h>

namespace kibori {

struct SeriesSpring {
  double stiffness_n_mm = 0.5;  // k
  double torsion_nmm_rad = 0;   // kt; 0: the tool turns as the device does, without a moment
  double friction = 0.2;        // Coulomb coefficient between tool and material
  double tick_s = 0.001;        // T
  double strength_n = 0;        // S, the hand's maximum pull; 0: unlimited
  double hand_share = 1;  // share of the cut's force that the hand supports (see kPoweredShare)

  // Visits all fields except those that a stroke's rate and ForceLaw define.
  static void for_fields(auto&& f) {
    constexpr FieldRange kNotNegative = FieldRange::not_negative;
    f(FieldInfo{"stiffness_n_mm", "stiffness", FieldRange::positive},
      &SeriesSpring::stiffness_n_mm);
    f(FieldInfo{"torsion_nmm_rad", "torsion", kNotNegative}, &SeriesSpring::torsion_nmm_rad);
    f(FieldInfo{"friction", "friction", kNotNegative}, &SeriesSpring::friction);
    f(FieldInfo{"strength_n", "strength", kNotNegative, Stored::unless_default},
      &SeriesSpring::strength_n);
  }
};

// Distance between a pointer and its tool at the hand's full strength. A pointer gets no force
// feedback, so stability does not limit k: it is S / this distance. With a smaller distance,
// rounding of the rays is visible in the force. With a larger one, a groove ends visibly before the
// pointer.
inline constexpr double kHandGiveMm = 0.25;
// Default strength of a hand: a carver who leans on a gouge without a mallet.
inline constexpr double kHandStrengthN = 200;
// Spring of a pointer's hand. Its stiffness follows from its strength.
inline SeriesSpring spring_of_hand(double strength_n = kHandStrengthN) {
  SeriesSpring spring;
  spring.strength_n = strength_n;
  spring.stiffness_n_mm = strength_n / kHandGiveMm;
  return spring;
}

// Wrench of the spring on a hand that is `stretch_mm` and `stretch_rad` away from the tool.
Wrench pull_of(const SeriesSpring& spring, const Vec3& stretch_mm, const Vec3& stretch_rad);

class SpringTool {
 public:
  // `start`: pose of the device and of the tool. The tool does not cut, and gives no force, until
  // it has been clear of material once.
  SpringTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : model_(model), edit_(model), tool_pose_(start), spring_(spring) {}

  // Moves the device to `device`. A deposit adds `material`. Mode::touch never cuts. A mode that
  // reshapes acts as `off`: ReshapeStroke edits the model. Errors: a jump or turn that needs more
  // than kMaxTurnSubsteps substeps; nothing has moved then. Does not allocate, lock or cause page
  // faults.
  //
  // If the spring has a strength and the device rests, only a tool that is far behind still moves,
  // until it stops. Then nothing moves, so the carving does not depend on how long a pointer rests.
  // `strike_nmm`: work of a mallet's blow. It drives a cutting tool towards the device until it has
  // done this work.
  Result<ToolTick> advance(const Tool& tool, const Pose& device, Mode mode,
                           const std::vector<Material>& materials, uint8_t material = 0,
                           double strike_nmm = 0);

  const Pose& pose() const { return tool_pose_; }
  const SeriesSpring& spring() const { return spring_; }
  void set_spring(const SeriesSpring& spring) {
    spring_ = spring;
    last_.known = false;
  }
  // Use `show` for a hand without a force device: where strength limits the depth, the tick then
  // reports the resistance of the cut. A force device gets the spring's own pull, which is stable
  // at rest.
  void show_resistance(bool show) { show_resistance_ = show; }
  // Images of the tool make the same edits. Call check_symmetry first.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // Sets the protected region, which is not cut and stops the tool as a rigid wall; null: none. The
  // region must outlive the tool or be unset first.
  void set_no_go(const NoGo* no_go) {
    edit_.set_no_go(no_go);
    if (no_go) Except::reserve();
    disengage();
  }
  // See ToolEdit::set_grows.
  void set_grows(bool grows) { edit_.set_grows(grows); }
  // Sets how the wood's grain changes the cutting force; null: the force uses each material's u
  // alone. `grain` must outlive the tool.
  void set_grain(const Grain* grain) { grain_ = grain; }
  // Moves the tool to `pose` without a path.
  void place(const Pose& pose) {
    tool_pose_ = pose;
    disengage();
  }
  // Clears the state of earlier strokes, so that the next stroke can be replayed alone.
  void begin_stroke() {
    begins_ = true;
    forget_cut();
    edit_.forget();
  }
  // Returns the first pose where `tool` is clear of material, backed out from `pose` along its
  // axis. Returns nothing if that is farther than twice the tool's reach. Does not allocate or
  // lock.
  std::optional<Pose> clear_place(const Tool& tool, const Pose& pose,
                                  const std::vector<Material>& materials);
  // Moves the tool to `pose`. Precondition: it is clear of material there (see clear_place).
  void place_clear(const Pose& pose) {
    place(pose);
    engaged_ = true;
  }
  // Call this when the model changed under the tool, or when the tool changed its shape. The tool
  // then waits until it is clear of material.
  void disengage() {
    engaged_ = touched_ = false;
    forget_cut();
    last_.known = false;
    normal_generation_ = kNever;
    edit_.forget();
  }
  // Volume that the last advance removed or added, by material. Includes the images.
  const Removed& removed() const { return removed_; }
  // Shape of the chip over the last cell of path. All zero if nothing was cut.
  const Chip& chip() const { return chip_; }

 private:
  struct Resistance;
  struct Tick;
  template <class F>
  void for_sweeps(const Tick& tick, double share, F&& f) const;
  double reach_volume(const Tick& tick, double share, const Grain* grain = nullptr,
                      bool chip = false);
  void measure_grain(const Tick& tick, double share);
  bool passes_thin(const Tick& tick, double share);
  double same_direction(const Tick& tick) const;
  const Chip& chip_shape(const Tick& tick, double share);
  Chip shape_of_trial(const Tick& tick, double share);
  void pay(const Tick& tick, const ToolMotion& path, const Pose& end);
  void forget_cut();
  Resistance resistance(const Tick& tick, double share, bool ahead = false);
  // The share of the path that the tool moves, and whether it touches there.
  struct Balance {
    double share;
    bool touching;
  };
  Balance balance(const Tick& tick, bool likely_touching);
  double slide(const Tick& tick, const Vec3& residual);
  double pull(double length_mm) const;
  double length_of(const ToolMotion& motion) const;
  void look_ahead(Tick& tick, const Pose& device) const;
  bool deflect(Tick& tick, const Vec3& up, double too_hard_n);
  double drawn_share(const Tick& tick, const Vec3& up, double force_n) const;
  Balance push(Tick& tick, const Vec3& up, bool likely_touching);
  double struck_share(const Tick& tick, double strike_nmm);
  const Vec3& contact_normal(const Tick& tick);
  double wall_volume(const Tick& tick, double share);
  bool keep_to_wall(Tick& tick);
  bool is_same_request(const Tool& tool, const Pose& device, Mode mode) const;
  void go(const Tick& tick, double share, ToolTick& result);
  void leave_material(const Tick& tick, ToolTick& result);
  Balance solve(Tick& tick, const Pose& device, double strike_nmm);
  void slide_on(const Tick& tick, const Pose& device, const Vec3& before);
  void work(Tick& tick, const Pose& device, bool puts_down, double strike_nmm, ToolTick& result);
  void finish(const Tick& tick, const Pose& device, const Vec3& before, ToolTick& result);

  TriDexel& model_;
  ToolEdit edit_;
  const Grain* grain_ = nullptr;
  Pose tool_pose_;
  SeriesSpring spring_;
  bool engaged_ = false, touched_ = false, begins_ = true;
  double last_step_mm_ = 0;
  static constexpr uint64_t kNever = ~uint64_t{0};
  uint64_t normal_generation_ = kNever;
  // Last normal, and the pose at which it was measured.
  Vec3 normal_ = Vec3::Zero();
  Pose normal_pose_;
  Removed removed_, trial_, twice_, walls_;
  // Cuts over the last cell of path.
  PathMean mean_;
  Chip chip_;
  double excess_mm2_ = 0;  // section of the chip minus the section computed from lengths of rays
  Vec3 last_displacement_mm_ = Vec3::Zero();
  bool show_resistance_ = false;
  // If strength limited the depth in this tick: the stretch at which the spring would pull with the
  // resistance of the cut.
  std::optional<Vec3> resisted_mm_;
  double rise_mm_ = 0;    // height by which the last tick raised the path: see deflect()
  double spare_nmm_ = 0;  // work that the hand did not need on raised paths: see kSpareDistance
  // Last tick, for a device that requests the same again.
  struct Last {
    bool known = false;
    // the tool is behind the device and still moves: the same request moves it farther
    bool moving = false;
    Tool tool;
    Pose device;
    Mode mode = Mode::off;
    uint64_t generation = kNever;
    ToolTick result;
  } last_;
};

}  // namespace kibori
