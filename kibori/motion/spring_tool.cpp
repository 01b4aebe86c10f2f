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

// The device asks for what it asked for in the last tick, and nothing has changed since.
bool SpringTool::asks_the_same(const Tool& tool, const Pose& device, Mode mode) const {
  return last_.known && !last_.on_its_way && last_.mode == mode &&
         last_.generation == model_.generation() && last_.device.tip == device.tip &&
         last_.device.frame == device.frame && tool == last_.tool;
}

// The tool goes a share of the way. All of it: to where the device is, its turn made as a replay
// makes it.
void SpringTool::go(const Tick& tick, double share, ToolTick& felt) {
  ToolMotion way = tick.motion.part(share);
  Pose end = way.at(1);
  if (share >= 1 && !resisted_mm_ && tick.rest_mm.isZero(0)) end.tip = tick.target;
  way.travel_mm = end.tip - tool_pose_.tip;
  felt.motion.turn = way.turns() ? way.turn_rad : Vec3(Vec3::Zero());
  if (felt.edited) {
    const Result<int> counted = substeps_of(tick.tool, way, model_.lattice());
    edit_.run(tick.tool, way, end, counted ? counted.value() : 1, tick.mode == Mode::deposit,
              tick.material, 1, removed_);
    removed_.add(edit_.images());
  }
  tool_pose_ = end;
}

// A tool that stands in material goes with the device until it is out.
void SpringTool::come_out(const Tick& tick, ToolTick& felt) {
  go(tick, 1, felt);
  Tick rest{tick.tool,
            {tool_pose_, Vec3::Zero(), Vec3::Zero()},
            model_.lattice().pitch_mm,
            Mode::touch,
            0,
            tick.materials};
  engaged_ = reach_volume(rest, 0) <= kTouchVolume && wall_volume(rest, 0) <= kTouchVolume;
  felt.inside = !engaged_;
}

// How far a tool that is clear, or deposits, goes. `strike_nmm`: see advance().
SpringTool::Balance SpringTool::solve(Tick& tick, const Pose& device, double strike_nmm) {
  const bool moves = tick.length > kMinStep * model_.lattice().pitch_mm;
  // Where our own last cut ended the tool stands clear; elsewhere it may stand in something.
  tick.clear = tick.mode != Mode::deposit && !tick.motion.turns() && engaged_ &&
               edit_.stands_clear(tick.tool, tool_pose_);
  bool touches = touched_;
  if (tick.mode == Mode::deposit) {
    tick.inside = reach_volume(tick, 0);  // what standing there would put down is for free
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

// A tool that stopped at a surface slides along it; what is in the way there, it slides along, too.
void SpringTool::slide_on(const Tick& tick, const Pose& device, const Vec3& before) {
  for (int faces = 0; faces < 2; faces++) {
    const Pose there = tool_pose_;
    const double share = slide(tick, device.tip - tool_pose_.tip);
    if (!(share > 0)) break;
    // Over the whole tick the spring must have pulled the tool its way.
    if ((device.tip - tool_pose_.tip).dot(tool_pose_.tip - before) < 0) {
      tool_pose_ = there;
      break;
    }
    if (share >= 1) break;  // else something is in the way, and it slides along that
  }
}

// A tick of a tool that is clear of material, or that deposits.
void SpringTool::work(Tick& tick, const Pose& device, bool puts_down, double strike_nmm,
                      ToolTick& felt) {
  const Vec3 before = tool_pose_.tip;
  const bool moves = tick.length > kMinStep * model_.lattice().pitch_mm;
  const bool resting = !moves && !tick.motion.turns() && (touched_ || !(tick.length > 0));
  const Balance at = resting ? Balance{0, false} : solve(tick, device, strike_nmm);
  if (!resisted_mm_ && !resting) rise_mm_ = spare_nmm_ = 0;
  felt.touching = (at.share < 1 || resisted_mm_) && !resting;
  if (resting) felt.touching = touched_;
  felt.touching |= tick.walled;
  felt.cutting = puts_down || (at.touching && tick.mode != Mode::touch && at.share > 0);
  felt.edited = felt.cutting;
  if (at.share > 0 || puts_down) go(tick, std::min(1.0, at.share), felt);
  if (at.share > 0) last_step_mm_ = at.share * tick.length;
  touched_ = felt.touching || felt.cutting;
  if (felt.touching && !tick.walled && !felt.cutting && !resting && !resisted_mm_ &&
      tick.mode != Mode::deposit)
    slide_on(tick, device, before);
  if (tick.mode == Mode::deposit) engaged_ = false;  // it stands in what it put down
}

// What came of the tick, into `felt` and for the next one.
void SpringTool::finish(const Tick& tick, const Pose& device, const Vec3& before, ToolTick& felt) {
  felt.pose = tool_pose_;
  felt.motion.tip = tool_pose_.tip;
  felt.motion.axis = tool_pose_.axis();
  felt.motion.travel = tool_pose_.tip - before;
  felt.points = removed_.points();
  const double h = model_.lattice().pitch_mm, cell = h * h * h;
  felt.removed_mm3 = (tick.mode == Mode::deposit ? -1 : 1) * removed_.mean_volume() * cell;
  felt.clipped = removed_.clipped;
  felt.stretch_mm =
      resisted_mm_ && show_resistance_ ? *resisted_mm_ : Vec3(device.tip - tool_pose_.tip);
  felt.wrench =
      pull_of(spring_, felt.stretch_mm,
              spring_.torsion_nmm_rad > 0 ? rotation_between(tool_pose_.frame, device.frame)
                                          : Vec3(Vec3::Zero()));
  if (tick.mode == Mode::off) felt.wrench = {};
  const bool on_its_way = !tick.whole && (felt.cutting || felt.pose.tip != before);
  last_ = {true, on_its_way, tick.tool, device, tick.mode, model_.generation(), felt};
  last_.felt.removed_mm3 = 0;
  last_.felt.points = 0;
  last_.felt.motion.travel = last_.felt.motion.turn = Vec3::Zero();
  last_.felt.cutting = last_.felt.edited = false;
}

Result<ToolTick> SpringTool::advance(const Tool& tool, const Pose& device, Mode mode,
                                     const std::vector<Material>& materials, uint8_t material,
                                     double strike_nmm) {
  if (reshapes(mode)) mode = Mode::off;
  removed_.reset();
  // A deposit puts the tool's body down where its stroke begins, however it moves.
  const bool puts_down = mode == Mode::deposit && std::exchange(begins_, false);
  if (spring_.strength_n > 0 && !puts_down && !(strike_nmm > 0) &&
      asks_the_same(tool, device, mode))
    return last_.felt;
  const Vec3 before = tool_pose_.tip;
  Tick tick{
      tool,
      {tool_pose_, device.tip - tool_pose_.tip, rotation_between(tool_pose_.frame, device.frame)},
      0,
      mode,
      material,
      materials};
  tick.length = length_of(tick.motion);
  if (tick.motion.turns()) {
    const double reach = reach_mm(tool);
    tick.reach2 = reach * reach;
  }
  const Result<int> substeps = substeps_of(tool, tick.motion, model_.lattice());
  if (!substeps) return Error{substeps.error()};
  tick.walled = mode == Mode::cut && engaged_ && keep_to_wall(tick);
  tick.target = tick.walled ? tool_pose_.tip + tick.motion.travel_mm : device.tip;
  if (spring_.strength_n > 0 && mode != Mode::off && (mode == Mode::deposit || engaged_))
    look_ahead(tick, device);
  resisted_mm_.reset();
  ToolTick felt;
  if (mode == Mode::off) {
    // It may go through material, and must then come out before it is felt again.
    if (tick.length > 0 || tick.motion.turns()) disengage();
    go(tick, 1, felt);
  } else if (mode != Mode::deposit && !engaged_) {
    come_out(tick, felt);
  } else {
    work(tick, device, puts_down, strike_nmm, felt);
  }
  finish(tick, device, before, felt);
  return felt;
}

}  // namespace kibori
