// SPDX-License-Identifier: MIT
#include <kibori/run/stroke_paths.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include <kibori/mill/tool_table.h>
#include <kibori/motion/mode.h>
#include <kibori/motion/tool_tick.h>

namespace kibori {
namespace {

// The tool is upright if its axis differs from z by less than this. At 100 mm above the tip, this
// is an error of 1e-5 mm.
constexpr double kUpright = 1e-7;
// Maximum number of points that one straight piece replaces. It limits the time per point.
constexpr size_t kMaxStraight = 256;

bool is_upright(const Vec3& axis) { return (axis - Vec3::UnitZ()).norm() < kUpright; }

bool is_straight(const StrokePath& path, size_t first, size_t last, double tolerance_mm) {
  const Vec3& from = path[first];
  const Vec3 way = path[last] - from;
  const double length2 = way.squaredNorm();
  double reached = 0;
  for (size_t i = first + 1; i < last; i++) {
    const double share = length2 > 0 ? (path[i] - from).dot(way) / length2 : 0;
    // A path that turns back may reach beyond the straight piece.
    if (share < reached || share > 1) return false;
    reached = share;
    if ((path[i] - from - share * way).norm() > tolerance_mm) return false;
  }
  return true;
}

StrokePath straightened(const StrokePath& path, double tolerance_mm) {
  StrokePath kept = {path.front()};
  for (size_t first = 0; first + 1 < path.size();) {
    size_t last = first + 1;
    while (last + 1 < path.size() && last - first < kMaxStraight &&
           is_straight(path, first, last + 1, tolerance_mm))
      last++;
    kept.push_back(path[last]);
    first = last;
  }
  return kept;
}

// Converts ticks to paths.
class PathReader {
 public:
  explicit PathReader(const Pose& start) { put(start); }

  void read(const RecordedTick& tick) {
    if (tick.second) return;
    if (const auto* const place = std::get_if<PutTick>(&tick.what)) return put(place->pose);
    const auto* const move = std::get_if<MoveTick>(&tick.what);
    if (!move) return;
    const ToolMotion motion{at_, move->tip - at_.tip, move->turn};
    at_ = moved_tick(motion, move->tip).pose;
    if (!move->edits) return put(at_);
    tilted_ |= !is_upright(motion.start.axis()) || !is_upright(at_.axis());
    cuts_ = true;
    path_.push_back(at_.tip);
  }
  std::vector<StrokePath> finish() {
    put(at_);
    return std::move(paths_);
  }
  bool tilted() const { return tilted_; }

 private:
  // Ends the current path and begins the next one.
  void put(const Pose& pose) {
    if (cuts_) paths_.push_back(std::move(path_));
    cuts_ = false;
    at_ = pose;
    path_ = {pose.tip};
  }

  Pose at_;
  StrokePath path_;
  std::vector<StrokePath> paths_;
  bool cuts_ = false, tilted_ = false;
};

Status check_settings(const StrokeSettings& settings) {
  if (settings.mode != Mode::cut)
    return Error{"uses the mode " + std::string(name_of(settings.mode)) +
                 ", and a machine can only cut"};
  if (settings.second && kind_of(settings.second->mode) != ModeKind::none)
    return Error{"uses two tools at the same time"};
  if (!is_round_cutter(settings.tool))
    return Error{"uses the tool " + std::string(shape_of(settings.tool)) +
                 ", which is not a milling cutter"};
  for (const SymmetryImage& image : SymmetryImages(settings.symmetry))
    if (!is_upright(image.turn * Vec3::UnitZ()))
      return Error{"uses a symmetry that tilts the tool"};
  return Ok{};
}

}  // namespace

bool changes_nothing(const StrokeSettings& settings) {
  return kind_of(settings.mode) == ModeKind::none &&
         (!settings.second || kind_of(settings.second->mode) == ModeKind::none);
}

bool is_round_cutter(const Tool& tool) {
  return std::visit(
      []<class Shape>(const Shape&) {
        return std::is_same_v<Shape, Flat> || std::is_same_v<Shape, BallTool> ||
               std::is_same_v<Shape, Bull> || std::is_same_v<Shape, Cone> ||
               std::is_same_v<Shape, Drill> || std::is_same_v<Shape, TaperedBall> ||
               std::is_same_v<Shape, Lollipop> || std::is_same_v<Shape, TSlot>;
      },
      tool);
}

Tool with_long_shaft(const Tool& tool, double height_mm) {
  if (const auto* ball = std::get_if<BallTool>(&tool))
    return ball_end_mill(ball->radius, height_mm);
  Tool longer = tool;
  for_tool_numbers(longer, [&](const std::string& name, auto& number) {
    if constexpr (std::is_same_v<decltype(number), double&>)
      if (name == "length") number = std::max(number, height_mm);
  });
  return longer;
}

Result<StrokePaths> stroke_paths(const Document& document, StepId step, double tolerance_mm) {
  const Result<StrokeSettings> settings = document.settings(step);
  if (!settings) return Error{settings.error()};
  if (const Status ok = check_settings(settings.value()); !ok) return Error{ok.error()};
  const Result<Pose> start = document.start(step);
  if (!start) return Error{start.error()};
  PathReader reader(start.value());
  const Status read = document.for_ticks(step, [&](const std::vector<RecordedTick>& ticks) {
    for (const RecordedTick& tick : ticks) reader.read(tick);
    return Status(Ok{});
  });
  if (!read) return Error{read.error()};
  if (reader.tilted()) return Error{"tilts the tool, and the machine keeps it upright"};
  StrokePaths result{settings.value().tool, {}};
  for (const StrokePath& path : reader.finish())
    result.paths.push_back(straightened(path, tolerance_mm));
  const SymmetryImages images(settings.value().symmetry);
  const size_t own = result.paths.size();
  for (const SymmetryImage& image : images)
    for (size_t i = 0; i < own; i++) {
      StrokePath path = result.paths[i];
      for (Vec3& point : path) point = image_of(point, images.centre_mm(), image);
      result.paths.push_back(std::move(path));
    }
  return result;
}

}  // namespace kibori
