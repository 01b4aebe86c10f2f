// SPDX-License-Identifier: MIT
// Force model `series`: the hand holds a spring, the spring holds the tool.
//
//   device x_d ──/\/\/\── tool x_p ──▶ material          F = -k (x_d - x_p), M = -kt theta
//
// Each tick the tool goes towards the device by the d in [0, L] that balances
//
//   k (L - d) = yield + u dV(d)/d + c dV(d)/T            (smallest root)
//
// where dV(d) is what it would newly reach; yield, u and c are the materials' means over that.
// Below yield nothing is cut: the tool stops where it touches and slides there against Coulomb
// friction. With a torsional spring, way and turn are one motion of length L^2 = |x_d - x_p|^2 +
// (kt/k) |theta|^2.
//
// Stiffness as felt never exceeds k, whatever the material, so stability is one inequality (see
// haptics/safety.h).
//
// A hand has strength, too: it pulls with min(S, k L). Where S can't drive the tool along all of
// its way, depth gives way before the way does: the tool follows sideways at the greatest depth
// that S affords.
//
//   hand   ────────────────▶   wanted: 2 mm deep
//   tool  ──╲________________   what S affords in this wood: 1.4 mm
#pragma once

#include <optional>
#include <vector>

#include <kibori/base/field_info.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/substeps.h>
#include <kibori/motion/tool_edit.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/solid/tool.h>

namespace kibori {

struct SeriesSpring {
  double stiffness_n_mm = 0.5;  // k
  double torsion_nmm_rad = 0;   // kt; 0: the tool turns as the device does, and no moment is felt
  double friction = 0.2;        // Coulomb's coefficient between tool and material
  double tick_s = 0.001;        // T
  double strength_n = 0;        // S, the most that the hand pulls with; 0: without bound
  double hand_share = 1;        // of the cut's force, what the hand bears (see kPoweredShare)

  // All but what it shares with a stroke's rate and with ForceLaw.
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

// How far a pointer's hand is from its tool when it pulls with all its strength: nothing is fed
// back to a pointer, so k = S / this, whatever the tick. Less, and rounding of the rays shows in
// the force; more, and a groove ends visibly before the pointer does.
inline constexpr double kHandGiveMm = 0.25;
// With how much a hand pushes unless it is said otherwise: a carver who leans on a gouge without a
// mallet.
inline constexpr double kHandStrengthN = 200;
// A pointer's hand: so strong, and as stiff as that makes it.
inline SeriesSpring spring_of_hand(double strength_n = kHandStrengthN) {
  SeriesSpring spring;
  spring.strength_n = strength_n;
  spring.stiffness_n_mm = strength_n / kHandGiveMm;
  return spring;
}

// What the spring does to the hand that is `stretch_mm` and `stretch_rad` from the tool.
Wrench pull_of(const SeriesSpring& spring, const Vec3& stretch_mm, const Vec3& stretch_rad);

class SpringTool {
 public:
  // `start`: where device and tool are. Nothing is felt or cut until the tool has once been clear
  // of material.
  SpringTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : model_(model), edit_(model), tool_pose_(start), spring_(spring) {}

  // The device moved to `device`. `material` is what a deposit puts down. Mode::touch never cuts; a
  // mode that reshapes is as off: ReshapeStroke does the rest. Errors: a jump or turn of more
  // substeps than kMaxTurnSubsteps; nothing has moved then. Neither allocates, locks nor faults.
  //
  // A device that is where it was in the last tick moves nothing, if the spring has a strength: so
  // what a pointer carves depends on its path alone, not on how long it rests. `strike_nmm`: a
  // mallet's blow drives a tool that cuts towards the device until it has done this work.
  Result<ToolTick> advance(const Tool& tool, const Pose& device, Mode mode,
                           const std::vector<Material>& materials, uint8_t material = 0,
                           double strike_nmm = 0);

  const Pose& pose() const { return tool_pose_; }
  const SeriesSpring& spring() const { return spring_; }
  void set_spring(const SeriesSpring& spring) {
    spring_ = spring;
    last_.known = false;
  }
  // What a hand without a force device is shown: the resistance of the cut against the tool's way,
  // where depth gave way. A device gets the spring's own pull, which is stable at rest.
  void show_resistance(bool show) { show_resistance_ = show; }
  // Mirrors every edit in these planes. Call check_symmetry first.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // What is not cut, and stops the tool as a rigid wall; null: nothing. It must outlive the tool,
  // or be taken away.
  void set_no_go(const NoGo* no_go) {
    edit_.set_no_go(no_go);
    if (no_go) Except::reserve();
    disengage();
  }
  // How the model's wood is felt; null: as its materials' u alone. It must outlive the tool.
  void set_grain(const Grain* grain) { grain_ = grain; }
  // Puts the tool elsewhere, without a way there.
  void place(const Pose& pose) {
    tool_pose_ = pose;
    disengage();
  }
  // What was known from before is forgotten, so that the stroke that begins can be carved again
  // alone.
  void begin_stroke() {
    begins_ = true;
    edit_.forget();
  }
  // Where `tool` that stands at `pose` is clear of material, backed out along its axis just as far
  // as it takes; nothing if that is farther than twice the tool's reach. Neither allocates nor
  // locks.
  std::optional<Pose> clear_place(const Tool& tool, const Pose& pose,
                                  const std::vector<Material>& materials);
  // Puts the tool there; it stands in no material (see clear_place).
  void place_clear(const Pose& pose) {
    place(pose);
    engaged_ = true;
  }
  // The model changed under the tool, or the tool its shape: wait until it is clear again.
  void disengage() {
    engaged_ = touched_ = false;
    last_.known = false;
    normal_generation_ = kNever;
    edit_.forget();
  }
  // What the last advance removed or added, by material, images included.
  const Removed& removed() const { return removed_; }

 private:
  struct Resistance;
  struct Tick;
  template <class F>
  void for_sweeps(const Tick& tick, double share, F&& f) const;
  double reach_volume(const Tick& tick, double share, const Grain* grain = nullptr);
  void feel_grain(const Tick& tick, double share);
  Resistance resistance(const Tick& tick, double share, bool ahead = false);
  // How far it goes, and whether it touches there.
  struct Balance {
    double share;
    bool touching;
  };
  Balance balance(const Tick& tick, bool likely_touching);
  double slide(const Tick& tick, const Vec3& residual);
  double pull(double length_mm) const;
  double length_of(const ToolMotion& motion) const;
  void look_ahead(Tick& tick, const Pose& device) const;
  bool give_way(Tick& tick, const Vec3& up, double too_hard_n);
  Balance push(Tick& tick, const Vec3& up, bool likely_touching);
  double struck_share(const Tick& tick, double strike_nmm);
  const Vec3& contact_normal(const Tick& tick);
  double wall_volume(const Tick& tick, double share);
  bool keep_to_wall(Tick& tick);
  bool asks_the_same(const Tool& tool, const Pose& device, Mode mode) const;
  void go(const Tick& tick, double share, ToolTick& felt);
  void come_out(const Tick& tick, ToolTick& felt);
  Balance solve(Tick& tick, const Pose& device, double strike_nmm);
  void slide_on(const Tick& tick, const Pose& device, const Vec3& before);
  void work(Tick& tick, const Pose& device, bool puts_down, double strike_nmm, ToolTick& felt);
  void finish(const Tick& tick, const Pose& device, const Vec3& before, ToolTick& felt);

  TriDexel& model_;
  ToolEdit edit_;
  const Grain* grain_ = nullptr;
  Pose tool_pose_;
  SeriesSpring spring_;
  bool engaged_ = false, touched_ = false, begins_ = true;
  double last_step_mm_ = 0;
  static constexpr uint64_t kNever = ~uint64_t{0};
  uint64_t normal_generation_ = kNever;
  // The last normal, and where it was felt.
  Vec3 normal_ = Vec3::Zero();
  Pose normal_pose_;
  Removed removed_, trial_, walls_;
  bool show_resistance_ = false;
  // The stretch of the cut's resistance, where depth gave way in this tick.
  std::optional<Vec3> resisted_mm_;
  double rise_mm_ = 0;    // by which depth gave way in the last tick
  double spare_nmm_ = 0;  // work that the hand could have done while depth gave way
  // The last tick, for one that asks for the same again.
  struct Last {
    bool known = false;
    bool on_its_way = false;  // it hangs behind and has gone on: the same again leads it farther
    Tool tool;
    Pose device;
    Mode mode = Mode::off;
    uint64_t generation = kNever;
    ToolTick felt;
  } last_;
};

}  // namespace kibori
