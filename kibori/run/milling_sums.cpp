// SPDX-License-Identifier: MIT
// Cuts the sweeps and computes their results: forces, collisions, gouges, sums of lines and tools.
#include <algorithm>
#include <cmath>
#include <limits>

#include <kibori/run/milling_run.h>

namespace kibori {
namespace {

// A tool plunges if the cosine of the angle between its axis and its path exceeds this.
constexpr double kPlunge = 0.9;
// Volume by which a sweep along a wall may overlap the wall because of rounding: kGrazing for each
// cell of its path, plus kGrazingVolume [cells^3]. Rays that graze a wall are exact to 0.01 cells.
constexpr double kGrazing = 0.02, kGrazingVolume = 0.5;

// Variance of the removed volume along a direction [cells^2].
double variance_along(const CutSums& sums, const Vec3& axis) {
  const auto& s = sums.second;
  const double second =
      s[0] * axis.x() * axis.x() + s[1] * axis.y() * axis.y() + s[2] * axis.z() * axis.z() +
      2 * (s[3] * axis.x() * axis.y() + s[4] * axis.x() * axis.z() + s[5] * axis.y() * axis.z());
  const double along = sums.moment.dot(axis) / sums.volume;
  return second / sums.volume - along * along;
}
// Length of a uniform rod with this variance.
double length_of(double variance) { return std::sqrt(std::max(0.0, 12 * variance)); }

// Depth of the removed volume along the tool's axis [cells]. A sloped path adds to the variance, so
// its part is subtracted.
double depth_along(const CutSums& sums, const Vec3& axis, const Vec3& travel_cells) {
  const double slope = travel_cells.dot(axis);
  return length_of(variance_along(sums, axis) - slope * slope / 12);
}

// Share of the path in which the tool cuts. A part of the path may be in air.
double cutting_share(const CutSums& sums, const Vec3& travel_cells) {
  const double path = travel_cells.norm();
  if (!(path > 0)) return 1;
  return std::min(1.0, length_of(variance_along(sums, travel_cells / path)) / path);
}

}  // namespace

void MillRun::flush() {
  if (cuts_.empty()) return;
  summary_.sweeps += static_cast<int64_t>(cuts_.size());
  const std::vector<CutSums> sums = cut_batch(model_, cuts_, batch_options());
  for (size_t i = 0; i < sums.size(); i++) account(pieces_[i], sums[i]);
  if (options_.fixtures) meet_fixtures();
  if (options_.target) cut_target();
  cuts_.clear();
  pieces_.clear();
}

// Finds collisions with the fixtures. No part of the tool may touch them, in feed and in rapid
// moves.
void MillRun::meet_fixtures() {
  for (BatchCut& cut : cuts_) cut.writes = cut.chip = false;
  const auto sums = cut_batch(*options_.fixtures, cuts_, batch_options());
  for (size_t i = 0; i < sums.size(); i++)
    if (more_than_grazing(pieces_[i], sums[i]))
      collide(pieces_[i], CollisionKind::fixture, mm3(sums[i]));
}

void MillRun::cut_target() {
  for (size_t i = 0; i < cuts_.size(); i++) {
    cuts_[i].writes = pieces_[i].kind != Piece::Kind::body;
    cuts_[i].chip = false;
  }
  const auto sums = cut_batch(*options_.target, cuts_, batch_options());
  for (size_t i = 0; i < sums.size(); i++)
    if (cuts_[i].writes && more_than_grazing(pieces_[i], sums[i])) gouge(cuts_[i], i, sums[i]);
}

void MillRun::gouge(const BatchCut& cut, size_t i, const CutSums& sums) {
  const Piece& piece = pieces_[i];
  const double volume = mm3(sums);
  const Vec3 middle =
      in_program(lattice_.to_mm(LatticePoint{cut.reference.units + sums.moment / sums.volume}));
  auto& all = summary_.gouges;
  if (!all.empty() && all.back().line == piece.line && all.back().program == piece.program) {
    MillGouge& last = all.back();
    last.place_mm =
        (last.volume_mm3 * last.place_mm + volume * middle) / (last.volume_mm3 + volume);
    last.volume_mm3 += volume;
  } else if (all.size() < kMaxGouges) {
    all.push_back({piece.program, piece.line, uses_[static_cast<size_t>(piece.tool_index)].number,
                   piece.time_s, middle, volume});
  } else {
    summary_.more_gouges++;
  }
}

BatchOptions MillRun::batch_options() const {
  return {options_.threads, options_.z_only ? BatchFields::z_only : BatchFields::all};
}
double MillRun::mm3(const CutSums& sums) const {
  return sums.volume * lattice_.pitch_mm * lattice_.pitch_mm * lattice_.pitch_mm;
}
bool MillRun::more_than_grazing(const Piece& piece, const CutSums& sums) const {
  const double path = (piece.travel_mm.norm() + 2 * piece.radius_mm) / lattice_.pitch_mm;
  return sums.volume > kGrazingVolume + kGrazing * path;
}

void MillRun::account(const Piece& piece, const CutSums& sums) {
  const double volume = mm3(sums);
  if (piece.kind != Piece::Kind::feed) {
    if (more_than_grazing(piece, sums)) collide(piece, piece.collision, volume);
    if (piece.kind == Piece::Kind::body) return;
  }
  MillToolUse& use = uses_[static_cast<size_t>(piece.tool_index)];
  use.removed_mm3 += volume;
  step_removed_mm3_ += volume;
  if (options_.tape) options_.tape->cut(piece.tape_move, volume);
  if (piece.line != result_.line || piece.program != result_.program) end_line();
  result_.program = piece.program;
  result_.line = piece.line;
  result_.tool = use.number;
  result_.path_mm += piece.travel_mm.norm();
  result_.seconds += piece.seconds;
  result_.removed_mm3 += volume;
  if (options_.forces && piece.kind == Piece::Kind::feed && sums.volume > kGrazingVolume)
    add_force(piece, sums, volume, use);
}

void MillRun::add_force(const Piece& piece, const CutSums& sums, double volume, MillToolUse& use) {
  const MillTool& tool = tools_[static_cast<size_t>(piece.tool_index)];
  const double path = piece.travel_mm.norm();
  const Vec3 axis = piece.start.axis();
  const CutterDrive drive{2 * piece.radius_mm, tool.teeth, piece.rpm};
  const Vec3 travel = piece.travel_mm / lattice_.pitch_mm;
  const double share = cutting_share(sums, travel);
  const CutPiece cut{volume, share * path, share * piece.seconds,
                     lattice_.pitch_mm * depth_along(sums, axis, share * travel),
                     std::abs(piece.travel_mm.dot(axis)) > kPlunge * path};
  const Engagement engagement = engagement_of(cut, drive);
  if (engagement.section_mm2 > result_.engagement.section_mm2) result_.engagement = engagement;
  use.max_chip_mm = std::max(use.max_chip_mm, engagement.chip_mm);
  const auto force = cutting_force(engagement, drive, options_.material);
  if (options_.feed_limits) {
    const bool known = drive.teeth > 0 && drive.rpm > 0 && piece.seconds > 0 &&
                       mean_cutting_energy(options_.material) > 0;
    // If all data are known but there is no force, the cut is too short to have a chip.
    if (force || !known) limit_feed(piece, engagement, force);
  }
  if (!force) return;
  if (force->force_n > result_.force.force_n) result_.force = *force;
  if (options_.tape) options_.tape->press(piece.tape_move, *force);
  use.max_power_w = std::max(use.max_power_w, force->power_w);
  if (force->force_n > use.max_force_n) {
    use.max_force_n = force->force_n;
    use.max_force_line = piece.line;
  }
}

// Limits the feed rate of the line. The limits apply at the commanded speed, even if the machine
// does not reach it.
void MillRun::limit_feed(const Piece& piece, const Engagement& engagement,
                         const std::optional<CuttingForce>& force) {
  result_.feed_mm_min = std::max(result_.feed_mm_min, piece.feed_mm_min);
  double factor = result_.feed_factor.value_or(std::numeric_limits<double>::infinity());
  if (force) {
    const FeedLimits& limits = *options_.feed_limits;
    const double ratio = std::min(limits.force_n / force->force_n, limits.power_w / force->power_w);
    factor = std::min(
        factor, piece.commanded_share * feed_factor_for(ratio, engagement, options_.material));
  } else {
    result_.force_unknown = true;
  }
  result_.feed_factor = factor;
}

void MillRun::end_line() {
  if (options_.line && result_.line > 0) options_.line(result_);
  result_ = {};
}

void MillRun::collide(const Piece& piece, CollisionKind kind, double volume) {
  std::vector<MillCollision>& all = summary_.collisions;
  if (!all.empty())
    for (auto last = all.rbegin(); last != all.rend() && last->line == piece.line; ++last)
      if (last->kind == kind && last->program == piece.program) {
        last->volume_mm3 += volume;
        return;
      }
  if (all.size() >= kMaxCollisions) {
    summary_.more_collisions++;
    return;
  }
  all.push_back({kind, piece.program, piece.line,
                 uses_[static_cast<size_t>(piece.tool_index)].number, piece.time_s,
                 in_program(piece.start.tip + piece.travel_mm), volume});
  if (options_.tape) options_.tape->collide(piece.tape_move);
}

}  // namespace kibori
