// SPDX-License-Identifier: MIT
// Converts a motion of the tool into an edit of the model. Hands, scripts and replays all use this
// class. Therefore, the same motions in the same order give the same bytes.
#pragma once

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/substeps.h>
#include <kibori/motion/symmetry.h>
#include <kibori/solid/no_go.h>
#include <kibori/solid/tool.h>

namespace kibori {

// Returns the Motion that an edit needs for its sums. Moments are about the tip at the end. If the
// tool turns, each element has its own displacement. `grain` is null if the wood has no grain.
// `chip` is Motion::chip.
Motion sums_of(const ToolMotion& motion, const Pose& end, const Lattice& lattice,
               const Grain* grain, bool chip = false);

// Returns the length of the tool's path in a tick [cells], over which forces are averaged. A turn
// counts as the path of a point at half the tool's reach.
double path_cells(const Tool& tool, const TickMotion& tick, double pitch_mm);

// Returns the weights of the three fields for sums of lengths of rays (Motion::along). They are the
// squared direction cosines of the motion, so that the reached length grows evenly. If the motion
// is mostly a turn, all three weights are equal.
Vec3 ray_weights(const ToolMotion& motion, double reach_mm);

class ToolEdit {
 public:
  explicit ToolEdit(TriDexel& model) : model_(model) {}

  // Sets the symmetry. The images of the tool make the same edits. Precondition: check_symmetry
  // accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry) { symmetry_ = SymmetryImages(symmetry); }

  // Sets the protected region, which edits do not cut; null: none. The region must outlive every
  // run().
  void set_no_go(const NoGo* no_go) {
    no_go_ = no_go;
    forget();
  }
  const NoGo* no_go() const { return no_go_; }

  // If `grows` is true, the lattice grows when a deposit needs room. Otherwise, its border cuts the
  // deposit off.
  void set_grows(bool grows) { grows_ = grows; }

  // Sets the grain of the wood, which changes the cutting force. Null: the force does not depend on
  // the direction of the fibres. `grain` must outlive every run().
  void set_grain(const Grain* grain) { grain_ = grain; }
  const Grain* grain() const { return grain_; }

  // Sets whether edits also compute the sums for the chip's shape (Motion::chip).
  void set_chip(bool chip) { chip_ = chip; }
  bool chip() const { return chip_; }

  // Grows the lattice for a deposit along `motion`, if growing is permitted. run() calls this
  // function.
  void make_room(const Tool& tool, const ToolMotion& motion, int substeps);

  // Sweeps the tool along `motion` to `end`, in `substeps` substeps (see substeps_of). If
  // `deposits` is true, deposits `material`; otherwise cuts. Adds the result to `removed`, without
  // the images.
  void run(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps, bool deposits,
           uint8_t material, int threads, Removed& removed);

  // Returns the volume that the images removed or added in the last run().
  const Removed& images() const { return images_; }

  // Returns true if no material is inside the tool at `pose`: the tool's own last cut ended at
  // `pose`, and the model has not changed since then.
  bool is_clear(const Tool& tool, const Pose& pose) const {
    return clear_generation_ == model_.generation() && tool == clear_tool_ &&
           pose.tip == clear_pose_.tip && pose.frame == clear_pose_.frame;
  }
  // Makes is_clear() return false until the next cut. Call it at the beginning of a stroke, so that
  // the result does not depend on earlier edits.
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
