// SPDX-License-Identifier: MIT
// Force model `series`: the hand holds a spring, the spring holds the tool.
//
//   device x_d ──/\/\/\── tool x_p ──▶ material          F = -k (x_d - x_p), M = -kt theta
//
// Each tick the tool goes towards the device by the d in [0, L] that balances
//
//   k (L - d) = yield + u dV(d)/d + c dV(d)/T            (smallest root)
//
// where dV(d) is what it would newly reach; yield, u and c are the materials' means over that. Below yield
// nothing is cut: the tool stops where it touches and slides there against Coulomb friction. With a torsional
// spring, way and turn are one motion of length L^2 = |x_d - x_p|^2 + (kt/k) |theta|^2.
//
// Stiffness as felt never exceeds k, whatever the material, so stability is one inequality (see
// haptics/safety.h).
#pragma once

#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/removed.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/pieces.h>
#include <kibori/motion/stroke.h>
#include <kibori/motion/tool_edit.h>
#include <kibori/solid/tool.h>

namespace kibori {

struct SeriesSpring {
  double stiffness_n_mm = 0.5;  // k
  double torsion_nmm_rad = 0;   // kt; 0: the tool turns as the device does, and no moment is felt
  double friction = 0.2;        // Coulomb's coefficient between tool and material
  double tick_s = 0.001;        // T
};

class SeriesTool {
 public:
  // `start`: where device and tool are. Nothing is felt or cut until the tool has once been clear of
  // material.
  SeriesTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : model_(model), edit_(model), tool_pose_(start), spring_(spring) {}

  // What one tick came to.
  struct Felt {
    Wrench hand;                   // on the hand: N, N mm about the device's position
    Pose tool;                     // where the tool is now
    double removed_mm3 = 0;        // negative: deposited
    double travel_mm = 0;          // how far the tool's tip went
    bool touching = false;         // material holds the tool back
    bool cutting = false;          // material was cut
    bool inside = false;           // the tool stands in material and waits to be pulled out: no force, no cut
    bool clipped = false;          // a deposit reached beyond the lattice
    Vec3 turn_rad = Vec3::Zero();  // by which the tool turned
    bool edited =
        false;  // the way was cut or filled: Stroke::advance to the tool's tip by this turn does the same
  };

  // The device moved to `device`. `material` is what a deposit puts down. Mode::touch never cuts. Errors: a
  // jump or turn of more pieces than kMaxTurnPieces; nothing has moved then. Neither allocates, locks nor
  // faults.
  Result<Felt> advance(const Tool& tool, const Pose& device, Mode mode,
                       const std::vector<Material>& materials, uint8_t material = 0);

  const Pose& pose() const { return tool_pose_; }
  const SeriesSpring& spring() const { return spring_; }
  void set_spring(const SeriesSpring& spring) { spring_ = spring; }
  // Whose images do the same; check_symmetry has passed.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // Puts the tool elsewhere, without a way there.
  void place(const Pose& pose) {
    tool_pose_ = pose;
    disengage();
  }
  // What was known from before is forgotten, so that the stroke that begins can be carved again alone.
  void begin_stroke() { edit_.forget(); }
  // The model changed under the tool, or the tool its shape: wait until it is clear again.
  void disengage() {
    engaged_ = touched_ = false;
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
  double reach_volume(const Tick& tick, double share);
  Resistance resistance(const Tick& tick, double share, bool ahead = false);
  // How far it goes, and whether it touches there.
  struct Balance {
    double share;
    bool touching;
  };
  Balance balance(const Tick& tick, bool likely_touching);
  double slide(const Tick& tick, const Vec3& residual);
  const Vec3& contact_normal(const Tick& tick);

  TriDexel& model_;
  ToolEdit edit_;
  Pose tool_pose_;
  SeriesSpring spring_;
  bool engaged_ = false, touched_ = false;
  double last_step_mm_ = 0;
  static constexpr uint64_t kNever = ~uint64_t{0};
  uint64_t normal_generation_ = kNever;
  // The last normal, and where it was felt.
  Vec3 normal_ = Vec3::Zero();
  Pose normal_pose_;
  Removed removed_, trial_;
};

}  // namespace kibori
