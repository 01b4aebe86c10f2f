// SPDX-License-Identifier: MIT
// SpringTool in contact: the surface's normal, sliding, and walls of the protected region.
#include <kibori/motion/spring_tick.h>

#include <kibori/edit/edit.h>

namespace kibori {

using namespace spring;

namespace {

// A sliding tool is lifted by this share of its displacement. Otherwise rounding of the normal
// would drive it into the material. The spring pulls it back in the next tick.
constexpr double kLift = 0.02;
constexpr double kNormalStep = 0.25;  // [cells] distance at which the normal is measured
// The protected region is in contact if the tool meets it within this distance [cells]. With a
// distance smaller than a lift, the tool oscillates. With a larger one, it stays away from the
// region.
constexpr double kWallReach = 0.1;
// Distance [cells] over which the normal of the region is measured. With a smaller one, too few
// rays meet a round wall.
constexpr double kWallStep = 1;
// Radius [cells] around the centre of contact in which the wall's own normals are used.
constexpr double kWallLookAround = 2.5;
// A tool that slides along the region is lifted from it by one of these shares of its displacement:
// the first one that keeps it out of the wall over the distance kWallLook [cells].
constexpr double kWallLifts[] = {0.02, 0.06, 0.2}, kWallLook = 0.5;
// Steps of the search for a clear place: the first one [cells], and the factor from one to the
// next. With this factor, the result is about a fifth farther away than necessary at most.
constexpr double kFirstBack = 1, kBackFactor = 1.2;

}  // namespace

// Direction out of the material where the tool touches: opposite to the growth of the volume that
// it would reach.
const Vec3& SpringTool::contact_normal(const Tick& tick) {
  if (normal_generation_ == model_.generation() && normal_pose_.tip == tool_pose_.tip &&
      normal_pose_.frame == tool_pose_.frame)
    return normal_;
  const double step = kNormalStep * model_.lattice().pitch_mm;
  Tick probe{tick.tool,     {tool_pose_, Vec3::Zero(), Vec3::Zero()}, step, Mode::touch, 0,
             tick.materials};
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      probe.motion.travel_mm = Vec3::Zero();
      probe.motion.travel_mm[i] = sign * step;
      growth[i] += sign * (reach_volume(probe, 1) + wall_volume(probe, 1));
    }
  const double length = std::sqrt(growth.squaredNorm());
  normal_ = length > 0 ? Vec3(-growth / length) : Vec3(Vec3::Zero());
  normal_generation_ = model_.generation();
  normal_pose_ = tool_pose_;
  return normal_;
}

// Slides along the surface, as far as friction and obstacles permit. Returns the share of that path
// that the tool moved.
double SpringTool::slide(const Tick& tick, const Vec3& residual) {
  const Vec3 normal = contact_normal(tick);
  const double pressed = -residual.dot(normal);
  if (!(pressed > 0)) return 0;
  const Vec3 along = residual + pressed * normal;
  const double length = std::sqrt(along.squaredNorm());
  double distance = length - spring_.friction * pressed;
  if (!(distance > kMinStep * model_.lattice().pitch_mm)) return 0;
  // Lifting must not put more energy into the spring than sliding releases.
  const double lift = std::min(kLift, 0.5 * length / pressed);
  distance = std::min(distance, kLookDistance * model_.lattice().pitch_mm);
  Tick slip{tick.tool, {tool_pose_, (along / length + lift * normal) * distance, Vec3::Zero()},
            distance,  Mode::touch,
            0,         tick.materials};
  slip.length = std::sqrt(slip.motion.travel_mm.squaredNorm());
  slip.inside = reach_volume(slip, 0);
  slip.wall_inside = wall_volume(slip, 0);
  const Balance at = balance(slip, false);
  if (!(at.share > 0) || passes_thin(slip, at.share)) return 0;
  tool_pose_ = slip.motion.at(at.share);
  return at.share;
}

// Guides a tool in contact with the protected region along it, as far as friction permits. The tool
// cuts the other material on this path. Returns false if there is no contact.
bool SpringTool::keep_to_wall(Tick& tick) {
  const double h = model_.lattice().pitch_mm;
  const Vec3 wanted = tick.motion.travel_mm;
  const double far = std::sqrt(wanted.squaredNorm());
  if (!edit_.no_go() || !(far > kMinStep * h)) return false;
  Tick probe{tick.tool,
             {tool_pose_, wanted * std::min(1.0, kWallReach * h / far), Vec3::Zero()},
             kWallReach * h,
             Mode::touch,
             0,
             tick.materials};
  const double inside = wall_volume(probe, 0);
  if (!(wall_volume(probe, 1) - inside > kMoreVolume + kTouchArea * kWallReach)) return false;
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      probe.motion.travel_mm = sign * kWallStep * h * Vec3::Unit(i);
      growth[i] += sign * wall_volume(probe, 1);
    }
  const double length = std::sqrt(growth.squaredNorm());
  if (!(length > 0)) return false;
  Vec3 normal = -growth / length;
  // If the wall is smooth, its own normals are better: the growth of the volume is uneven, because
  // single rays enter.
  probe.motion.travel_mm = -kWallStep * h * normal;
  const double met = wall_volume(probe, 1);
  Vec3 moment = Vec3::Zero();
  walls_.for_parts([&](int, const RemovedPart& part) { moment += part.moment; });
  const LatticePoint middle = model_.lattice().to_lattice(tool_pose_.tip + probe.motion.travel_mm) +
                              LatticeVector{moment / met};
  const Vec3 smooth = met > 0 ? edit_.no_go()->normal_near(middle, kWallLookAround) : Vec3::Zero();
  if (smooth.dot(normal) > 0.5) normal = smooth;
  const double pressed = -wanted.dot(normal);
  if (!(pressed > 0)) return false;
  const Vec3 along = wanted + pressed * normal;
  const double slack = std::sqrt(along.squaredNorm());
  const double distance = slack - spring_.friction * pressed;
  tick.motion.travel_mm = Vec3::Zero();
  if (distance > kMinStep * h)
    for (const double lift : kWallLifts) {
      tick.motion.travel_mm =
          (along / slack + std::min(lift, 0.5 * slack / pressed) * normal) * distance;
      const double near = std::min(distance, kWallLook * h);
      probe.motion.travel_mm = tick.motion.travel_mm * (near / distance);
      if (wall_volume(probe, 1) - inside <= kMoreVolume + kTouchArea * near / h) break;
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
