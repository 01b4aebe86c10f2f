// SPDX-License-Identifier: MIT
#include <kibori/motion/tool_edit.h>

#include <algorithm>
#include <utility>

namespace kibori {
namespace {

// Upper limit of path_cells() [cells]. Only a turning tool with a huge reach would exceed it.
constexpr double kMaxPathCells = 1e9;

// Threshold for "mostly turns": the squared ratio of the farthest point's displacement by the turn
// to that by the shift. Below it, the weights follow the direction of the shift. Without the
// threshold, the force on a blade that turns slowly in a bend would vary by as much as its mean.
constexpr double kTurnDominance = 16;

}  // namespace

double path_cells(const Tool& tool, const TickMotion& tick, double pitch_mm) {
  double path = std::sqrt(tick.travel.squaredNorm());
  const double turn = std::sqrt(tick.turn.squaredNorm());
  if (turn > 0) path += 0.5 * turn * reach_mm(tool);
  return std::min(path / pitch_mm, kMaxPathCells);
}

Vec3 ray_weights(const ToolMotion& motion, double reach_mm) {
  const double length2 = motion.travel_mm.squaredNorm();
  if (!(length2 > 0) ||
      motion.turn_rad.squaredNorm() * reach_mm * reach_mm > kTurnDominance * length2)
    return Vec3::Constant(1.0 / 3);
  return motion.travel_mm.cwiseAbs2() / length2;
}

Motion sums_of(const ToolMotion& motion, const Pose& end, const Lattice& lattice,
               const Grain* grain, bool chip) {
  return {lattice.to_lattice(end.tip),
          motion.turns(),
          lattice.vector_to_lattice(motion.travel_mm),
          motion.turn_rad,
          end.axis(),
          grain,
          grain ? grain->across2(motion.travel_mm) : 1,
          nullptr,
          chip};
}

void ToolEdit::make_room(const Tool& tool, const ToolMotion& motion, int substeps) {
  if (!grows_ || std::holds_alternative<HalfSpace>(tool)) return;  // a half-space is infinite
  for (int i = 0; i < substeps; i++) {
    // The lattice limits the height of the tool's solid, so its bounds can grow with the lattice.
    for (bool grew = true; grew;) {
      const SweptTool sweep(tool, motion.substep(i, substeps), motion.travel_mm / substeps,
                            model_.lattice());
      grew = model_.grow_to(sweep.solid().bounds());
    }
  }
}

void ToolEdit::sweep(const Tool& tool, const ToolMotion& motion, const Pose& end, int substeps,
                     bool deposits, uint8_t material, int threads, bool clear, Removed& removed) {
  const Lattice& lattice = model_.lattice();
  EditOptions options{sums_of(motion, end, lattice, grain_, chip_), threads};
  if (chip_) options.motion.length_weights = ray_weights(motion, reach_mm(tool));
  if (deposits) make_room(tool, motion, substeps);
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
  const bool turns = motion.turns(), clear = !deposits && !turns && is_clear(tool, motion.start);
  sweep(tool, motion, end, substeps, deposits, material, threads, clear, removed);
  images_.reset();
  const bool chip = std::exchange(chip_, false);  // images do not count for the chip
  for (const SymmetryImage& image : symmetry_)
    sweep(tool, image_of(motion, tool, symmetry_.centre_mm(), image),
          image_of(end, tool, symmetry_.centre_mm(), image), substeps, deposits, material, threads,
          false, images_);
  chip_ = chip;
  // If there is a protected region, its material may remain inside the tool.
  if (deposits || turns || no_go_) return forget();
  clear_generation_ = model_.generation();
  clear_tool_ = tool;
  clear_pose_ = end;
}

}  // namespace kibori
