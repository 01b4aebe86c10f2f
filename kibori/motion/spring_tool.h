// SPDX-License-Identifier: MIT
// Force model `series`: the hand holds a spring, and the spring holds the tool. The code calls the
// hand `device`.
//
//   device x_d ──/\/\/\── tool x_p ──▶ material          F = -k (x_d - x_p), M = -kt theta
//
// In each tick, the tool moves towards the device by a distance d in [0, L]. L is the distance
// between tool and device. d is the smallest root of
//
//   k (L - d) = yield + u dV(d)/d + c dV(d)/T
//
// T is the duration of a tick. dV(d) is the volume that the tool would newly reach. yield, u and c
// are means of the materials in this volume. The law of haptics/chip.h gives u.
//
// dV(d)/d is the sum of two parts. The first part is computed from lengths of rays, because they
// grow evenly with d. But lengths underestimate thin cuts. So the second part is a correction: the
// amount by which the volumes of cuts exceeded their lengths, as a mean over the last cell of path
// (haptics/path_mean.h). This mean lags by about half a cell. The lag does not violate passivity.
// The tool only moves towards the device, so the spring releases energy for any value of the force.
//
// If the spring pulls with less than the yield force, the tool cuts nothing. It stops at the first
// contact, and slides there against Coulomb friction. If the spring resists turns (kt),
// displacement and turn are one motion of the length L^2 = |x_d - x_p|^2 + (kt/k) |theta|^2.
//
// For any material, the effective stiffness is at most k. Therefore, one inequality decides about
// stability (see haptics/safety.h).
//
// A hand may also have a strength S. Then the pull is min(S, k L). If S cannot drive the tool along
// its whole path, the tool follows the hand sideways, but cuts less deep: at the largest depth that
// S permits.
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
  double torsion_nmm_rad = 0;   // kt; 0: the tool turns exactly with the device, without a moment
  double friction = 0.2;        // coefficient of Coulomb friction between tool and material
  double tick_s = 0.001;        // T [s]
  double strength_n = 0;        // S, the maximum pull of the hand; 0: unlimited
  double hand_share = 1;  // share of the cutting force that the hand supports (see kPoweredShare)

  // Visits all members except tick_s and hand_share, which follow from the stroke's rate and
  // ForceLaw.
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

// Distance between a pointer and its tool when the hand pulls with its full strength. A pointer
// gets no force feedback, so stability does not limit k. Therefore, k is S divided by this
// distance. With a smaller distance, rounding errors of the rays would be visible in the force.
// With a larger distance, a groove would end visibly before the pointer.
inline constexpr double kHandGiveMm = 0.25;
// Default strength of a hand: a carver who leans on a gouge, without a mallet.
inline constexpr double kHandStrengthN = 200;
// Returns the spring of a pointer's hand. The stiffness follows from the strength.
inline SeriesSpring spring_of_hand(double strength_n = kHandStrengthN) {
  SeriesSpring spring;
  spring.strength_n = strength_n;
  spring.stiffness_n_mm = strength_n / kHandGiveMm;
  return spring;
}

// Returns the wrench of the spring on the hand. `stretch_mm` and `stretch_rad` are the displacement
// and the turn from the tool to the hand.
Wrench pull_of(const SeriesSpring& spring, const Vec3& stretch_mm, const Vec3& stretch_rad);

class SpringTool {
 public:
  // Places device and tool at `start`. Until the tool has been clear of material once, it cuts
  // nothing and gives no force.
  SpringTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : model_(model), edit_(model), tool_pose_(start), spring_(spring) {}

  // Moves the device to `device`, and the tool as far as the balance permits. A deposit adds
  // `material`. Mode::touch never cuts. A mode that reshapes acts as `off`, because ReshapeStroke
  // edits the model. Errors: the motion needs more than kMaxTurnSubsteps substeps; then nothing has
  // moved. Except with a mesh as the tool, advance() does not allocate, lock or cause page faults.
  //
  // If the spring has a strength and the device rests, the tool moves only while it is far behind
  // the device. When it stops, nothing moves until the device moves. So the carving does not depend
  // on how long a pointer rests. `strike_nmm` is the work of a mallet's blow. The blow drives a
  // cutting tool towards the device until this work is done.
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
  // Pass true for a hand without a force device. Then, if the strength limits the depth, the tick
  // reports the resistance of the cut instead of the spring's pull. A force device needs the pull,
  // which is stable at rest.
  void show_resistance(bool show) { show_resistance_ = show; }
  // Sets the symmetry. The images of the tool make the same edits. Precondition: check_symmetry
  // accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // Sets the protected region, which is not cut and stops the tool like a rigid wall; null: none.
  // The region must outlive the tool or be unset before its end.
  void set_no_go(const NoGo* no_go) {
    edit_.set_no_go(no_go);
    if (no_go) Except::reserve();
    disengage();
  }
  // See ToolEdit::set_grows.
  void set_grows(bool grows) { edit_.set_grows(grows); }
  // Sets the grain of the wood, which changes the cutting force. Null: only each material's u
  // counts. `grain` must outlive the tool.
  void set_grain(const Grain* grain) { grain_ = grain; }
  // Moves device and tool to `pose` without a path.
  void place(const Pose& pose) {
    tool_pose_ = pose;
    disengage();
  }
  // Forgets earlier strokes, so that the next stroke can be replayed alone.
  void begin_stroke() {
    begins_ = true;
    forget_cut();
    edit_.forget();
  }
  // Moves `tool` from `pose` out along its axis, in growing steps. Returns the first pose at which
  // the tool is clear of material. Returns nothing if there is none within about twice the tool's
  // reach. Does not allocate or lock.
  std::optional<Pose> clear_place(const Tool& tool, const Pose& pose,
                                  const std::vector<Material>& materials);
  // Moves the tool to `pose`, where it must be clear of material (see clear_place).
  void place_clear(const Pose& pose) {
    place(pose);
    engaged_ = true;
  }
  // Call this when the model changed under the tool, or when the tool changed its shape. Then the
  // tool does not work until it is clear of material.
  void disengage() {
    engaged_ = touched_ = false;
    forget_cut();
    last_.known = false;
    normal_generation_ = kNever;
    edit_.forget();
  }
  // Returns the volume that the last advance() removed or added, for each material, with the
  // images.
  const Removed& removed() const { return removed_; }
  // Returns the shape of the chip over the last cell of path. All values are zero if nothing was
  // cut.
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
  // `share`: the share of the path along which the tool moves. `touching`: the tool touches there.
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
  // The last normal, and the pose at which it was measured.
  Vec3 normal_ = Vec3::Zero();
  Pose normal_pose_;
  Removed removed_, trial_, twice_, walls_;
  // The cuts over the last cell of path.
  PathMean mean_;
  Chip chip_;
  double excess_mm2_ = 0;  // section of the chip, minus the section that lengths of rays give
  Vec3 last_displacement_mm_ = Vec3::Zero();
  bool show_resistance_ = false;
  // Set if the strength limited the depth in this tick: the stretch at which the spring's pull
  // would equal the resistance of the cut.
  std::optional<Vec3> resisted_mm_;
  double rise_mm_ = 0;    // height by which the last tick raised the path; see deflect()
  double spare_nmm_ = 0;  // work that the hand did not need on raised paths; see kSpareDistance
  // The last tick. It is the result again if the device requests the same pose.
  struct Last {
    bool known = false;
    // The tool is behind the device and still moves. The same request would move it farther.
    bool moving = false;
    Tool tool;
    Pose device;
    Mode mode = Mode::off;
    uint64_t generation = kNever;
    ToolTick result;
  } last_;
};

}  // namespace kibori
