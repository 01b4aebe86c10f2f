// SPDX-License-Identifier: MIT
#include <kibori/motion/substeps.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <kibori/base/tolerances.h>

namespace kibori {

bool ToolMotion::turns() const { return std::sqrt(turn_rad.squaredNorm()) > kNoTurn; }

Pose ToolMotion::at(double share) const {
  return {start.tip + travel_mm * share,
          turns() ? Mat3(rotation(turn_rad * share) * start.frame) : start.frame};
}

Pose ToolMotion::substep(int i, int substeps) const {
  Pose from = start;
  from.tip = start.tip + travel_mm * (static_cast<double>(i) / substeps);
  if (turns()) from.frame = rotation(turn_rad * ((i + 0.5) / substeps)) * start.frame;
  return from;
}

double pieces_needed(const Tool& tool, const ToolMotion& motion, const Lattice& lattice) {
  if (!motion.start.tip.allFinite() || !motion.travel_mm.allFinite() ||
      !motion.turn_rad.allFinite())
    return std::numeric_limits<double>::infinity();
  const double scale = 1 / lattice.pitch_mm, angle = std::sqrt(motion.turn_rad.squaredNorm());
  double stray = 0;
  if (motion.turns()) {
    // Points beyond the lattice meet no material, so their deviation does not matter.
    double reach = 0;
    for (int corner = 0; corner < 8; corner++) {
      Vec3 p = Vec3::Zero();
      for (int i = 0; i < 3; i++) p[i] = (corner >> i) & 1 ? lattice.high()[i] : lattice.low()[i];
      reach = std::fmax(
          reach, std::sqrt((lattice.to_mm(LatticePoint{p}) - motion.start.tip).squaredNorm()));
    }
    stray = std::fmin(reach, reach_mm(tool)) * scale * angle / 2;
  }
  const double length = std::sqrt(motion.travel_mm.squaredNorm()) * scale;
  return std::fmax(
      1, std::fmax(std::ceil(stray / kTurnTolerance), std::ceil(length / kMaxPieceLength)));
}

Result<int> substeps_of(const Tool& tool, const ToolMotion& motion, const Lattice& lattice) {
  const double wanted = pieces_needed(tool, motion, lattice);
  if (wanted <= kMaxTurnSubsteps) return static_cast<int>(wanted);
  char text[200];
  std::snprintf(text, sizeof text,
                "one tick moves the tool by %.3g mm and %.3g degrees, which needs more than %d "
                "substeps; move slower",
                std::sqrt(motion.travel_mm.squaredNorm()),
                std::sqrt(motion.turn_rad.squaredNorm()) * 180 / 3.14159265358979,
                kMaxTurnSubsteps);
  return Error{text};
}

}  // namespace kibori
