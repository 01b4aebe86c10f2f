// SPDX-License-Identifier: MIT
#include <kibori/motion/stroke.h>

#include <cmath>

#include <kibori/motion/pieces.h>

namespace kibori {
namespace {

bool same_ball(const Tool& a, const Tool& b) {
  return std::holds_alternative<BallTool>(a) && same_tool(a, b);
}

}  // namespace

void Stroke::piece(const Tool& tool, const Pose& from, const Pose& last, const Vec3& travel, Mode mode,
                   uint8_t material, const EditOptions& options) {
  const Lattice& lattice = model_.lattice();
  const Box everywhere{Vec3::Zero(), lattice.nodes.matrix().cast<double>()};
  switch (mode) {
    case Mode::cut: {
      const bool clear = clear_ && clear_generation_ == model_.generation() && same_ball(tool, clear_tool_) &&
                         from.frame == last.frame;
      const SweptTool sweep(tool, from, travel, lattice, model_.material_bounds(), clear);
      cut(model_, sweep.solid(), options, removed_);
      return;
    }
    case Mode::deposit: {
      const SweptTool sweep(tool, from, travel, lattice, everywhere);
      deposit(model_, sweep.solid(), material, options, removed_);
      return;
    }
    case Mode::touch: {
      // Newly inside: in the sweep, but not where the tool already was.
      const SweptTool sweep(tool, from, travel, lattice, model_.material_bounds());
      const SweptTool start(tool, last, Vec3::Zero(), lattice, model_.material_bounds());
      if (std::holds_alternative<MeshTool>(tool)) {
        // Not convex, but the start pose is part of the sweep: its share is taken away.
        Removed before;
        contact(model_, start, options, before);
        contact(model_, sweep, options, removed_);
        removed_.add(before, -1);
        return;
      }
      contact(model_, Difference(sweep, start), options, removed_);
      return;
    }
    case Mode::off:
      return;
  }
}

Result<TickResult> Stroke::advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad, Mode mode,
                                   const ForceLaw& law, const std::vector<Material>& materials,
                                   uint8_t material) {
  const Lattice& lattice = model_.lattice();
  const double scale = 1 / lattice.pitch_mm;
  TickResult result;
  const ToolMotion motion{pose_, tip_mm - pose_.tip, turn_rad};
  const bool turning = motion.turns();
  const Vec3& travel = motion.travel_mm;
  Pose end = motion.at(1);
  end.tip = tip_mm;
  result.tick = {end.tip, end.axis(), travel, turning ? turn_rad : Vec3(Vec3::Zero())};
  removed_.reset();
  if (mode != Mode::off) {
    const Result<int> counted = pieces_of(tool, motion, lattice);
    if (!counted) return Error{counted.error()};
    const int pieces = counted.value();
    EditOptions options;
    options.threads = threads_;
    options.motion = {lattice.to_lattice(tip_mm), turning, travel * scale, turn_rad, end.axis()};
    // A touch in several pieces is a cut that is taken back: what one piece reaches, the next must not count
    // again.
    const bool take_back = mode == Mode::touch && pieces > 1;
    Snapshot before;
    if (take_back) {
      before = model_.snapshot();
      Removed inside;
      const SweptTool start(tool, pose_, Vec3::Zero(), lattice, model_.material_bounds());
      cut(model_, start, options, inside);
    }
    Pose last = pose_;
    for (int i = 0; i < pieces; i++) {
      const Pose from = motion.piece(i, pieces);
      last.tip = from.tip;
      piece(tool, from, last, travel / pieces, take_back ? Mode::cut : mode, material, options);
      last = from;
    }
    if (take_back) model_.restore(before);
    clear_ = mode == Mode::cut && !turning && std::holds_alternative<BallTool>(tool);
    clear_generation_ = model_.generation();
    if (clear_) clear_tool_ = tool;
    const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
    const double sign = mode == Mode::deposit ? -1 : 1;
    result.removed_mm3 = sign * removed_.mean_volume() * cell;
    result.points = removed_.points();
    result.clipped = removed_.clipped;
    result.wrench = wrench(law, removed_, result.tick, lattice.pitch_mm, lattice.origin_mm, materials);
  } else {
    clear_ = false;
  }
  pose_ = end;
  return result;
}

}  // namespace kibori
