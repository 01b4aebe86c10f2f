// SPDX-License-Identifier: MIT
#include <kibori/motion/spring_tick.h>

#include <kibori/edit/edit.h>

namespace kibori {

using namespace spring;

namespace {

// A tool that slides is lifted by this share of its way, so that rounding of the normal does not
// run it into the material; the spring takes it back in the next tick.
constexpr double kLift = 0.02;
constexpr double kNormalStep = 0.25;  // cells: how far to feel around for the normal
// What is not cut is at hand where it is met within this way [cells]: less than a lift takes the
// tool off it, and it would go to and fro; more, and it would be held off it.
constexpr double kWallReach = 0.1;
// Its normal is felt over this way [cells]: over less a round wall has too few rays there.
constexpr double kWallStep = 1;
// And so far around the middle of what is met [cells], where it is smooth.
constexpr double kWallLookAround = 2.5;
// By which shares of its way it is lifted so that it does not run into the wall over this way
// [cells]: the first that is enough.
constexpr double kWallLifts[] = {0.02, 0.06, 0.2}, kWallLook = 0.5;
// Steps of the search for a clear place: the first in cells, each longer than the last by this
// factor, so that a place is overshot by a fifth of the way at most.
constexpr double kFirstBack = 1, kBackFactor = 1.2;

}  // namespace

// The direction out of the material where the tool touches: against the growth of what it would
// reach.
const Vec3& SpringTool::contact_normal(const Tick& tick) {
  if (normal_generation_ == model_.generation() && normal_pose_.tip == tool_pose_.tip &&
      normal_pose_.frame == tool_pose_.frame)
    return normal_;
  const double step = kNormalStep * model_.lattice().pitch_mm;
  Tick feel{tick.tool,     {tool_pose_, Vec3::Zero(), Vec3::Zero()}, step, Mode::touch, 0,
            tick.materials};
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      feel.motion.travel_mm = Vec3::Zero();
      feel.motion.travel_mm[i] = sign * step;
      growth[i] += sign * (reach_volume(feel, 1) + wall_volume(feel, 1));
    }
  const double length = std::sqrt(growth.squaredNorm());
  normal_ = length > 0 ? Vec3(-growth / length) : Vec3(Vec3::Zero());
  normal_generation_ = model_.generation();
  normal_pose_ = tool_pose_;
  return normal_;
}

// Along the surface, as far as friction lets the spring pull it and nothing is in the way: the
// share of that way that it went.
double SpringTool::slide(const Tick& tick, const Vec3& residual) {
  const Vec3 normal = contact_normal(tick);
  const double pressed = -residual.dot(normal);
  if (!(pressed > 0)) return 0;
  const Vec3 along = residual + pressed * normal;
  const double length = std::sqrt(along.squaredNorm());
  double way = length - spring_.friction * pressed;
  if (!(way > kMinStep * model_.lattice().pitch_mm)) return 0;
  // Lifting must not take more from the spring than sliding gives back.
  const double lift = std::min(kLift, 0.5 * length / pressed);
  way = std::min(way, kLookWay * model_.lattice().pitch_mm);
  Tick slip{tick.tool, {tool_pose_, (along / length + lift * normal) * way, Vec3::Zero()},
            way,       Mode::touch,
            0,         tick.materials};
  slip.length = std::sqrt(slip.motion.travel_mm.squaredNorm());
  slip.inside = reach_volume(slip, 0);
  slip.wall_inside = wall_volume(slip, 0);
  const Balance at = balance(slip, false);
  if (!(at.share > 0)) return 0;
  tool_pose_ = slip.motion.at(at.share);
  return at.share;
}

// A tool that stands at what is not cut is led along it, as far as friction lets the spring pull
// it, and cuts what is in its way there. False: it does not stand there.
bool SpringTool::keep_to_wall(Tick& tick) {
  const double h = model_.lattice().pitch_mm;
  const Vec3 wanted = tick.motion.travel_mm;
  const double far = std::sqrt(wanted.squaredNorm());
  if (!edit_.no_go() || !(far > kMinStep * h)) return false;
  Tick feel{tick.tool,
            {tool_pose_, wanted * std::min(1.0, kWallReach * h / far), Vec3::Zero()},
            kWallReach * h,
            Mode::touch,
            0,
            tick.materials};
  const double inside = wall_volume(feel, 0);
  if (!(wall_volume(feel, 1) - inside > kMoreVolume + kTouchArea * kWallReach)) return false;
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      feel.motion.travel_mm = sign * kWallStep * h * Vec3::Unit(i);
      growth[i] += sign * wall_volume(feel, 1);
    }
  const double length = std::sqrt(growth.squaredNorm());
  if (!(length > 0)) return false;
  Vec3 normal = -growth / length;
  // Where the wall is smooth its own normals are better: rays that come in one by one roughen the
  // growth.
  feel.motion.travel_mm = -kWallStep * h * normal;
  const double met = wall_volume(feel, 1);
  Vec3 moment = Vec3::Zero();
  walls_.for_parts([&](int, const RemovedPart& part) { moment += feel.moment(part); });
  const LatticePoint middle = model_.lattice().to_lattice(tool_pose_.tip + feel.motion.travel_mm) +
                              LatticeVector{moment / met};
  const Vec3 smooth = met > 0 ? edit_.no_go()->normal_near(middle, kWallLookAround) : Vec3::Zero();
  if (smooth.dot(normal) > 0.5) normal = smooth;
  const double pressed = -wanted.dot(normal);
  if (!(pressed > 0)) return false;
  const Vec3 along = wanted + pressed * normal;
  const double slack = std::sqrt(along.squaredNorm());
  const double way = slack - spring_.friction * pressed;
  tick.motion.travel_mm = Vec3::Zero();
  if (way > kMinStep * h)
    for (const double lift : kWallLifts) {
      tick.motion.travel_mm =
          (along / slack + std::min(lift, 0.5 * slack / pressed) * normal) * way;
      const double near = std::min(way, kWallLook * h);
      feel.motion.travel_mm = tick.motion.travel_mm * (near / way);
      if (wall_volume(feel, 1) - inside <= kMoreVolume + kTouchArea * near / h) break;
    }
  tick.length = length_of(tick.motion);
  return true;
}

std::optional<Pose> SpringTool::clear_place(const Tool& tool, const Pose& pose,
                                            const std::vector<Material>& materials) {
  const double h = model_.lattice().pitch_mm, max = 2 * reach_mm(tool) + 4 * h;
  double back = 0, step = kFirstBack * h;
  for (;;) {
    const Pose there{pose.tip + back * pose.axis(), pose.frame};
    Tick rest{tool, {there, Vec3::Zero(), Vec3::Zero()}, h, Mode::touch, 0, materials};
    if (reach_volume(rest, 0) <= kTouchVolume && wall_volume(rest, 0) <= kTouchVolume) return there;
    if (!(back < max)) return std::nullopt;
    back += step;
    step *= kBackFactor;
  }
}

}  // namespace kibori
