// SPDX-License-Identifier: MIT
// The one way a motion of the tool becomes an edit of the model, by a hand, a script or a replay:
// the same motions in the same order leave the same bytes.
#pragma once

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/motion/substeps.h>
#include <kibori/motion/symmetry.h>
#include <kibori/solid/no_go.h>
#include <kibori/solid/tool.h>

namespace kibori {

// How sums over an edit are taken: about the tip at the end, and where the tool turns by each
// element's own way; `grain`: of wood that is felt, or null; `passing`: as of Motion.
Motion sums_of(const ToolMotion& motion, const Pose& end, const Lattice& lattice,
               const Grain* grain, bool passing = false);

class ToolEdit {
 public:
  explicit ToolEdit(TriDexel& model) : model_(model) {}

  // Whose images do the same; check_symmetry has passed.
  void set_symmetry(const Symmetry& symmetry) { symmetry_ = SymmetryImages(symmetry); }

  // What is not cut; null: nothing. It must outlive what is run.
  void set_no_go(const NoGo* no_go) {
    no_go_ = no_go;
    forget();
  }
  const NoGo* no_go() const { return no_go_; }

  // How the model's wood is felt; null: as its materials' u alone. It must outlive what is run.
  void set_grain(const Grain* grain) { grain_ = grain; }
  const Grain* grain() const { return grain_; }

  // Whether what resists is summed as what the tool's surface passes (Motion::passing); else not.
  void set_passing(bool passing) { passing_ = passing; }
  bool passing() const { return passing_; }

  // Sweeps the tool along `motion` to `end` in so many substeps (see substeps_of) and cuts, or
  // where `deposits` is set puts down `material`. Adds to `removed`; what the images did is in
  // images().
  void run(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps, bool deposits,
           uint8_t material, int threads, Removed& removed);

  // What the images of the last run removed or added.
  const Removed& images() const { return images_; }

  // Whether the tool there is known to stand in no material: where its own last cut ended, and
  // nothing has changed since.
  bool stands_clear(const Tool& tool, const Pose& pose) const {
    return clear_generation_ == model_.generation() && tool == clear_tool_ &&
           pose.tip == clear_pose_.tip && pose.frame == clear_pose_.frame;
  }
  // Nothing is known any more: at the beginning of a stroke, so that it does not depend on what was
  // before.
  void forget() { clear_generation_ = kNever; }

 private:
  static constexpr uint64_t kNever = ~uint64_t{0};
  void sweep(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps,
             bool deposits, uint8_t material, int threads, bool clear, Removed& removed);

  TriDexel& model_;
  const NoGo* no_go_ = nullptr;
  const Grain* grain_ = nullptr;
  bool passing_ = false;
  SymmetryImages symmetry_;
  Removed images_;
  uint64_t clear_generation_ = kNever;
  Tool clear_tool_;
  Pose clear_pose_;
};

}  // namespace kibori
