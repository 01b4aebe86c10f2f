// SPDX-License-Identifier: MIT
// Converts a motion of the tool into an edit of the model. Hands, scripts and replays all use it:
// the same motions in the same order leave the same bytes.
#pragma once

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/substeps.h>
#include <kibori/motion/symmetry.h>
#include <kibori/solid/no_go.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The Motion for an edit's sums. Moments are about the tip at the end. If the tool turns, each
// element uses its own displacement. `grain`: of wood with grain, or null. `chip`: see
// Motion::chip.
Motion sums_of(const ToolMotion& motion, const Pose& end, const Lattice& lattice,
               const Grain* grain, bool chip = false);

// Path length of a tick [cells], over which forces are averaged. A turn counts as the path of a
// point at half the tool's reach.
double path_cells(const Tool& tool, const TickMotion& tick, double pitch_mm);

// Weights of the three fields if lengths of rays are summed instead of volumes (Motion::along).
// They are the squared direction cosines of the motion, so that the reached length grows evenly. If
// the motion is mostly a turn, all three are equal.
Vec3 ray_weights(const ToolMotion& motion, double reach_mm);

class ToolEdit {
 public:
  explicit ToolEdit(TriDexel& model) : model_(model) {}

  // Images of the tool make the same edits. Precondition: check_symmetry accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry) { symmetry_ = SymmetryImages(symmetry); }

  // Sets the protected region, which is not cut; null: none. It must outlive every run().
  void set_no_go(const NoGo* no_go) {
    no_go_ = no_go;
    forget();
  }
  const NoGo* no_go() const { return no_go_; }

  // Sets whether a deposit that needs room grows the model's lattice. Else the border cuts it off.
  void set_grows(bool grows) { grows_ = grows; }

  // Sets how the wood's grain changes the cutting force; null: the force uses each material's u
  // alone. It must outlive every run().
  void set_grain(const Grain* grain) { grain_ = grain; }
  const Grain* grain() const { return grain_; }

  // Sets whether edits also sum the quantities for the chip's shape (Motion::chip).
  void set_chip(bool chip) { chip_ = chip; }
  bool chip() const { return chip_; }

  // Grows the lattice for a deposit along `motion`, if it may grow. run() does so, too.
  void make_room(const Tool& tool, const ToolMotion& motion, int substeps);

  // Sweeps the tool along `motion` to `end` in `substeps` substeps (see substeps_of). Cuts, or
  // deposits `material` if `deposits` is set. Adds the result to `removed`; images() returns what
  // the images did.
  void run(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps, bool deposits,
           uint8_t material, int threads, Removed& removed);

  // Volume that the images of the last run removed or added.
  const Removed& images() const { return images_; }

  // True if the tool at `pose` is known to be clear of material: its own last cut ended there, and
  // the model has not changed since.
  bool is_clear(const Tool& tool, const Pose& pose) const {
    return clear_generation_ == model_.generation() && tool == clear_tool_ &&
           pose.tip == clear_pose_.tip && pose.frame == clear_pose_.frame;
  }
  // After this call, is_clear() returns false until the next cut. A stroke calls it at its
  // beginning, so that its result does not depend on earlier edits.
  void forget() { clear_generation_ = kNever; }

 private:
  static constexpr uint64_t kNever = ~uint64_t{0};
  void sweep(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps,
             bool deposits, uint8_t material, int threads, bool clear, Removed& removed);

  TriDexel& model_;
  const NoGo* no_go_ = nullptr;
  const Grain* grain_ = nullptr;
  bool chip_ = false, grows_ = false;
  SymmetryImages symmetry_;
  Removed images_;
  uint64_t clear_generation_ = kNever;
  Tool clear_tool_;
  Pose clear_pose_;
};

}  // namespace kibori
