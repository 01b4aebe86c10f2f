// SPDX-License-Identifier: MIT
#include <kibori/motion/tool_edit.h>

namespace kibori {

Motion sums_of(const ToolMotion& motion, const Pose& end, const Lattice& lattice,
               const Grain* grain, bool passing) {
  return {lattice.to_lattice(end.tip),
          motion.turns(),
          lattice.vector_to_lattice(motion.travel_mm),
          motion.turn_rad,
          end.axis(),
          grain,
          grain ? grain->across2(motion.travel_mm) : 1,
          passing && motion.travel_mm.squaredNorm() > 0};
}

void ToolEdit::sweep(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps,
                     bool deposits, uint8_t material, int threads, bool clear, Removed& removed) {
  const Lattice& lattice = model_.lattice();
  const EditOptions options{sums_of(motion, end, lattice, grain_, passing_ && &removed != &images_),
                            threads};
  for (int i = 0; i < substeps; i++) {
    const SweptTool sweep(tool, motion.substep(i, substeps), motion.travel_mm / substeps, lattice,
                          clear && i == 0);
    if (deposits)
      deposit(model_, sweep.solid(), material, options, removed);
    else if (no_go_)
      cut(model_, Except(sweep.solid(), *no_go_), options, removed);
    else
      cut(model_, sweep.solid(), options, removed);
  }
}

void ToolEdit::run(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps,
                   bool deposits, uint8_t material, int threads, Removed& removed) {
  const bool turns = motion.turns(),
             clear = !deposits && !turns && stands_clear(tool, motion.start);
  sweep(tool, motion, end, substeps, deposits, material, threads, clear, removed);
  images_.reset();
  for (const SymmetryImage& image : symmetry_)
    sweep(tool, image_of(motion, tool, symmetry_.centre_mm(), image),
          image_of(end, tool, symmetry_.centre_mm(), image), substeps, deposits, material, threads,
          false, images_);
  // Beside what is not cut, material may be left where the tool stands.
  if (deposits || turns || no_go_) return forget();
  clear_generation_ = model_.generation();
  clear_tool_ = tool;
  clear_pose_ = end;
}

}  // namespace kibori
