// SPDX-License-Identifier: MIT
#include <kibori/motion/stroke.h>

#include <cmath>
#include <cstdio>

namespace kibori {
namespace {

bool same_ball(const Tool& a, const Tool& b) {
  const auto *x = std::get_if<BallTool>(&a), *y = std::get_if<BallTool>(&b);
  return x && y && x->radius == y->radius;
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
  const Vec3 travel = tip_mm - pose_.tip;
  const double angle = std::sqrt(turn_rad.squaredNorm());
  const bool turning = angle > kNoTurn;
  Pose end{tip_mm, turning ? Mat3(rotation(turn_rad) * pose_.frame) : pose_.frame};
  result.tick = {end.tip, end.axis(), travel, turning ? turn_rad : Vec3(Vec3::Zero())};
  removed_.reset();
  if (mode != Mode::off) {
    double stray = 0;
    if (turning) {
      // Points beyond the lattice meet nothing, so they may stray.
      double reach = 0;
      for (int corner = 0; corner < 8; corner++) {
        Vec3 p = Vec3::Zero();
        for (int i = 0; i < 3; i++) p[i] = (corner >> i) & 1 ? lattice.nodes[i] : 0;
        reach = std::fmax(reach, std::sqrt((lattice.to_mm(p) - pose_.tip).squaredNorm()));
      }
      stray = std::fmin(reach, reach_mm(tool)) * scale * angle / 2;
    }
    const double length = std::sqrt(travel.squaredNorm()) * scale;
    const double wanted = std::fmax(std::ceil(stray / kTurnTolerance), std::ceil(length / kMaxPieceLength));
    if (!(wanted <= kMaxTurnPieces)) {
      char text[200];
      std::snprintf(
          text, sizeof text,
          "one tick moves the tool by %.3g mm and %.3g degrees, which takes more than %d pieces; go slower",
          length * lattice.pitch_mm, angle * 180 / 3.14159265358979, kMaxTurnPieces);
      return Error{text};
    }
    const int pieces = std::max(1, static_cast<int>(wanted));
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
      Pose from = pose_;
      from.tip = pose_.tip + travel * (static_cast<double>(i) / pieces);
      if (turning) from.frame = rotation(turn_rad * ((i + 0.5) / pieces)) * pose_.frame;
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
