// SPDX-License-Identifier: MIT
#include <kibori/motion/spring_tool.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <kibori/motion/spring_tick.h>

namespace kibori {

using namespace spring;

Wrench pull_of(const SeriesSpring& spring, const Vec3& stretch_mm, const Vec3& stretch_rad) {
  const double k = spring.stiffness_n_mm, kt = spring.torsion_nmm_rad;
  double share = 1;
  if (spring.strength_n > 0) {
    const double length =
        std::sqrt(stretch_mm.squaredNorm() + (k > 0 ? kt / k : 0) * stretch_rad.squaredNorm());
    if (k * length > spring.strength_n) share = spring.strength_n / (k * length);
  }
  Wrench w;
  w.force = -(share * k) * stretch_mm;
  if (kt > 0) w.moment = -(share * kt) * stretch_rad;
  return w;
}

// Sets components of a travel below kDrift to zero, if another component is much larger. Such
// drifts are rounding errors. If a flat face moves along a plane of nodes, a drift would make it
// cut whole rows of cells.
static Vec3 without_drift(Vec3 travel_mm, double pitch_mm) {
  constexpr double kDrift = 1e-4;  // [cells]
  if (!(travel_mm.cwiseAbs().maxCoeff() > 10 * kDrift * pitch_mm)) return travel_mm;
  for (double& component : travel_mm)
    if (std::abs(component) < kDrift * pitch_mm) component = 0;
  return travel_mm;
}

// True if the device requests the same as in the last tick and nothing has changed since.
bool SpringTool::is_same_request(const Tool& tool, const Pose& device, Mode mode) const {
  return last_.known && !last_.moving && last_.mode == mode &&
         last_.generation == model_.generation() && last_.device.tip == device.tip &&
         last_.device.frame == device.frame && tool == last_.tool;
}

// Moves the tool by a share of the path. A share of 1 ends exactly at the device, and its turn is
// computed as a replay computes it.
void SpringTool::go(const Tick& tick, double share, ToolTick& result) {
  ToolMotion path = tick.motion.part(share);
  Pose end = path.at(1);
  if (share >= 1 && !resisted_mm_ && tick.rest_mm.isZero(0)) end.tip = tick.target;
  path.travel_mm = end.tip - tool_pose_.tip;
  result.motion.turn = path.turns() ? path.turn_rad : Vec3(Vec3::Zero());
  if (result.edited) {
    const Result<int> counted = substeps_of(tick.tool, path, model_.lattice());
    edit_.set_chip(tick.mode == Mode::cut);
    edit_.run(tick.tool, path, end, counted ? counted.value() : 1, tick.mode == Mode::deposit,
              tick.material, 1, removed_);
  }
  pay(tick, path, end);
  if (result.edited) removed_.add(edit_.images());
  tool_pose_ = end;
}

// Adds the volume that was cut along `path` to the sliding mean, and advances the mean by `path`.
void SpringTool::pay(const Tick& tick, const ToolMotion& path, const Pose& end) {
  const double h = model_.lattice().pitch_mm;
  if (tick.mode != Mode::cut || path.travel_mm.dot(last_displacement_mm_) < 0) forget_cut();
  last_displacement_mm_ = path.travel_mm;
  const TickMotion done{end.tip, end.axis(), path.travel_mm,
                        path.turns() ? path.turn_rad : Vec3(Vec3::Zero())};
  const double cells = path_cells(tick.tool, done, h);
  if (tick.mode != Mode::cut || !(cells > 0)) return;
  mean_.put_cells(removed_.cells(), cells);
  removed_.for_parts([&](int i, const RemovedPart& part) {
    if (part.has_chip) mean_.put(i, resistance_of(part, done, h), cells);
  });
  mean_.pay(cells);
  ChipMoments whole;
  mean_.for_paid([&](int, const PathMean::Resistance& paid) { whole.add(paid.chip, 1); });
  chip_ = chip_of(whole, cells, h, mean_.gaps());
  excess_mm2_ = chip_.section_mm2 > 0 ? h * h * (whole.volume - whole.length) / cells : 0;
}

void SpringTool::forget_cut() {
  mean_.drop();
  chip_ = {};
  excess_mm2_ = 0;
  last_displacement_mm_ = Vec3::Zero();
}

// A tool inside material follows the device until it is clear.
void SpringTool::leave_material(const Tick& tick, ToolTick& result) {
  go(tick, 1, result);
  Tick rest{tick.tool,
            {tool_pose_, Vec3::Zero(), Vec3::Zero()},
            model_.lattice().pitch_mm,
            Mode::touch,
            0,
            tick.materials};
  engaged_ = reach_volume(rest, 0) <= kTouchVolume && wall_volume(rest, 0) <= kTouchVolume;
  result.inside = !engaged_;
}

// Computes the share of the path for a tool that is clear of material or deposits. `strike_nmm`:
// see advance().
SpringTool::Balance SpringTool::solve(Tick& tick, const Pose& device, double strike_nmm) {
  const bool moves = tick.length > kMinStep * model_.lattice().pitch_mm;
  // The tool is clear of material if its own last cut ended here. Otherwise it may overlap some.
  tick.clear = tick.mode != Mode::deposit && !tick.motion.turns() && engaged_ &&
               edit_.is_clear(tick.tool, tool_pose_);
  bool touches = touched_;
  if (tick.mode == Mode::deposit) {
    tick.inside = reach_volume(tick, 0);  // the volume inside at the start causes no force
  } else if (!tick.clear && (touches || resistance(tick, 1).touching)) {
    Tick rest = tick;
    rest.mode = Mode::touch;
    tick.inside = reach_volume(rest, 0);
    tick.wall_inside = wall_volume(rest, 0);
    touches = true;
  }
  if (moves && tick.mode == Mode::cut && strike_nmm > 0)
    return {struck_share(tick, strike_nmm), true};
  if (moves && tick.mode == Mode::cut && spring_.strength_n > 0)
    return push(tick, device.axis(), touches && touched_);
  if (moves) return balance(tick, touches && touched_);
  return {resistance(tick, 1).touching ? 0.0 : 1.0, false};
}

// A tool that stopped at a surface slides along it. It also slides along the next surface it meets.
void SpringTool::slide_on(const Tick& tick, const Pose& device, const Vec3& before) {
  for (int faces = 0; faces < 2; faces++) {
    const Pose there = tool_pose_;
    const double share = slide(tick, device.tip - tool_pose_.tip);
    if (!(share > 0)) break;
    // Over the whole tick, the tool must have moved in the direction in which the spring pulls.
    if ((device.tip - tool_pose_.tip).dot(tool_pose_.tip - before) < 0) {
      tool_pose_ = there;
      break;
    }
    if (share >= 1) break;  // otherwise it met another surface, and slides along that
  }
}

// One tick of a tool that is clear of material or that deposits.
void SpringTool::work(Tick& tick, const Pose& device, bool puts_down, double strike_nmm,
                      ToolTick& result) {
  const Vec3 before = tool_pose_.tip;
  const bool moves = tick.length > kMinStep * model_.lattice().pitch_mm;
  const bool resting = !moves && !tick.motion.turns() && (touched_ || !(tick.length > 0));
  Balance at = resting ? Balance{0, false} : solve(tick, device, strike_nmm);
  if (!at.touching && at.share >= 1 && moves && tick.mode == Mode::cut)
    at.touching = passes_thin(tick, 1);
  if (!resisted_mm_ && !resting) rise_mm_ = spare_nmm_ = 0;
  result.touching = (at.share < 1 || resisted_mm_) && !resting;
  if (resting) result.touching = touched_;
  result.touching |= tick.walled;
  result.cutting = puts_down || (at.touching && tick.mode != Mode::touch && at.share > 0);
  result.edited = result.cutting;
  if (at.share > 0 || puts_down) go(tick, std::min(1.0, at.share), result);
  if (at.share > 0) last_step_mm_ = at.share * tick.length;
  touched_ = result.touching || result.cutting;
  if (result.touching && !tick.walled && !result.cutting && !resting && !resisted_mm_ &&
      tick.mode != Mode::deposit)
    slide_on(tick, device, before);
  if (tick.mode == Mode::deposit) engaged_ = false;  // it is inside the material that it deposited
}

// Writes the tick's result to `result`, and stores it for the next tick.
void SpringTool::finish(const Tick& tick, const Pose& device, const Vec3& before,
                        ToolTick& result) {
  result.pose = tool_pose_;
  result.motion.tip = tool_pose_.tip;
  result.motion.axis = tool_pose_.axis();
  result.motion.travel = tool_pose_.tip - before;
  result.points = removed_.points();
  const double h = model_.lattice().pitch_mm, cell = h * h * h;
  result.removed_mm3 = (tick.mode == Mode::deposit ? -1 : 1) * removed_.volume() * cell;
  result.clipped = removed_.clipped;
  result.stretch_mm =
      resisted_mm_ && show_resistance_ ? *resisted_mm_ : Vec3(device.tip - tool_pose_.tip);
  result.wrench =
      pull_of(spring_, result.stretch_mm,
              spring_.torsion_nmm_rad > 0 ? rotation_between(tool_pose_.frame, device.frame)
                                          : Vec3(Vec3::Zero()));
  if (tick.mode == Mode::off) result.wrench = {};
  const bool moving = !tick.whole && (result.cutting || result.pose.tip != before);
  last_ = {true, moving, tick.tool, device, tick.mode, model_.generation(), result};
  last_.result.removed_mm3 = 0;
  last_.result.points = 0;
  last_.result.motion.travel = last_.result.motion.turn = Vec3::Zero();
  last_.result.cutting = last_.result.edited = false;
}

Result<ToolTick> SpringTool::advance(const Tool& tool, const Pose& device, Mode mode,
                                     const std::vector<Material>& materials, uint8_t material,
                                     double strike_nmm) {
  if (reshapes(mode)) mode = Mode::off;
  removed_.reset();
  // A deposit adds the tool's body where its stroke begins, for any motion.
  const bool puts_down = mode == Mode::deposit && std::exchange(begins_, false);
  if (spring_.strength_n > 0 && !puts_down && !(strike_nmm > 0) &&
      is_same_request(tool, device, mode))
    return last_.result;
  const Vec3 before = tool_pose_.tip;
  Tick tick{tool,
            {tool_pose_,
             touched_ ? without_drift(device.tip - tool_pose_.tip, model_.lattice().pitch_mm)
                      : Vec3(device.tip - tool_pose_.tip),
             rotation_between(tool_pose_.frame, device.frame)},
            0,
            mode,
            material,
            materials};
  if (last_.known) tick.hand_mm = device.tip - last_.device.tip;
  tick.length = length_of(tick.motion);
  if (tick.motion.turns()) {
    const double reach = reach_mm(tool);
    tick.reach = reach;
  }
  const Result<int> substeps = substeps_of(tool, tick.motion, model_.lattice());
  if (!substeps) return Error{substeps.error()};
  tick.walled = mode == Mode::cut && engaged_ && keep_to_wall(tick);
  tick.target = tick.walled || tick.motion.travel_mm != device.tip - tool_pose_.tip
                    ? tool_pose_.tip + tick.motion.travel_mm
                    : device.tip;
  if (spring_.strength_n > 0 && mode != Mode::off && (mode == Mode::deposit || engaged_))
    look_ahead(tick, device);
  resisted_mm_.reset();
  ToolTick result;
  if (mode == Mode::off) {
    // The tool may pass through material. It must then be clear before it works again.
    if (tick.length > 0 || tick.motion.turns()) disengage();
    go(tick, 1, result);
  } else if (mode != Mode::deposit && !engaged_) {
    leave_material(tick, result);
  } else {
    work(tick, device, puts_down, strike_nmm, result);
  }
  finish(tick, device, before, result);
  return result;
}

}  // namespace kibori
