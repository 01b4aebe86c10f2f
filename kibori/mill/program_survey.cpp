// SPDX-License-Identifier: MIT
#include <kibori/mill/program_survey.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include <kibori/mill/arc.h>
#include <kibori/mill/canon_move.h>

namespace kibori {
namespace {

// Minimum thickness of a suggested block below the path, and minimum length of its sides [mm].
constexpr double kMinFloor = 1, kMinSide = 1;
// Points of an arc that count for the bounds.
constexpr int kArcPoints = 32;

class Surveyor {
 public:
  void operator()(const RapidMove& move) { go(move.to); }
  // Without its start, because a plunge begins above the part.
  void operator()(const FeedMove& move) {
    go(move.to);
    include(at_.xyz_mm);
  }
  void operator()(const ArcMove& move) {
    const ArcPath path(at_.xyz_mm, move);
    for (int i = 0; i <= kArcPoints; i++) include(path.at(static_cast<double>(i) / kArcPoints));
    go(move.to);
  }
  void operator()(const ToolSelect& select) { survey.tools.insert(select.number); }
  void operator()(const ToolChange& change) { survey.tools.insert(change.number); }
  template <class Other>
  void operator()(const Other&) {}

  ProgramSurvey survey;

 private:
  void go(const AxisPosition& to) {
    survey.moves++;
    survey.turns |= !to.abc_deg.isZero(0);
    at_ = to;
  }
  void include(const Vec3& place) {
    if (!place.allFinite()) return;
    if (!survey.feed_mm) survey.feed_mm.emplace();
    survey.feed_mm->include(place);
  }

  AxisPosition at_;
};

}  // namespace

Result<ProgramSurvey> survey_program(const std::filesystem::path& path, const Rs274Limits& limits) {
  Result<std::unique_ptr<Program>> program = open_program(path, {}, {}, limits);
  if (!program) return Error{program.error()};
  Surveyor surveyor;
  std::vector<CanonMove> moves;
  while (true) {
    moves.clear();
    const Result<bool> more = program.value()->next(moves);
    if (!more) return Error{more.error()};
    if (!more.value()) break;
    if (limits.stop && *limits.stop) return Error{path.string() + ": the survey was stopped"};
    for (const CanonMove& move : moves) std::visit(surveyor, move.action);
  }
  surveyor.survey.tools.erase(0);
  return surveyor.survey;
}

std::optional<Box> suggested_stock(const std::vector<ProgramSurvey>& surveys, double radius_mm) {
  Box path;
  bool any = false;
  for (const ProgramSurvey& survey : surveys) {
    if (!survey.feed_mm) continue;
    path.include(survey.feed_mm->min);
    path.include(survey.feed_mm->max);
    any = true;
  }
  if (!any) return std::nullopt;
  for (int axis = 0; axis < 2; axis++) {
    path.min[axis] -= radius_mm;
    path.max[axis] += radius_mm;
  }
  if (path.min.z() < 0) path.max.z() = 0;
  path.min.z() -= std::max(kMinFloor, 0.1 * (path.max.z() - path.min.z()));
  // Rounded outwards to tenths of a millimetre, as a user would write it.
  for (int axis = 0; axis < 3; axis++) {
    path.min[axis] = std::floor(10 * path.min[axis]) / 10;
    path.max[axis] = std::max(std::ceil(10 * path.max[axis]) / 10, path.min[axis] + kMinSide);
  }
  return path;
}

}  // namespace kibori
