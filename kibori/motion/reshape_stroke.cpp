// SPDX-License-Identifier: MIT
#include <kibori/motion/reshape_stroke.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/check.h>
#include <kibori/reshape/paint_dab.h>

namespace kibori {
namespace {

// Minimum distance between dabs [cells].
constexpr double kMinSpacing = 0.5;

// A crease's dab at full strength. It pulls the surface together by kCreasePinch of the distance.
// It sinks the surface by kCreaseDepth of the brush's radius, within kCreaseWidth of that radius.
// About four dabs pinch each place and two sink it. So a stroke at half strength leaves a valley a
// fifth of a radius deep.
constexpr double kCreasePinch = 0.2, kCreaseDepth = 0.2, kCreaseWidth = 0.5;

// A warp is computed again after the hand turned by this angle [rad].
constexpr double kTurnBetween = 0.1;

// Stiffness of a warp's pull, as a share of u times the brush's radius. A quick pull in clay gives
// a force of some newtons; in oak it needs a hand's full strength.
constexpr double kPullShare = 0.1;

// Distance between two returns of pressed material, as a share of the collar's radius. Then the
// number of collars at each return, and the number of rounds at a stroke's end.
constexpr double kPressSpacing = 0.1;
constexpr int kCollars = 3, kLastCollars = 40;
// Growth of the collar's radius per round at the stroke's end, and its maximum, relative to the
// first.
constexpr double kWiden = 1.2, kWidest = 4;
// Whenever the tip has moved this far [cells], the profile meets the tool, and the whole body is
// rebuilt.
constexpr double kWheelSpacing = 1;
// Share of a lathe's cutting force that the hand supports. It is about the ratio of the feed to the
// speed of the rim: tens of mm/s to metres per second.
constexpr double kLatheShare = 0.01;
// Share of the pressed volume that may stay pending during the stroke, and at its end.
constexpr double kPendingShare = 4e-3, kLastPendingShare = 1e-6;
// Share of the pending volume that may remain: after one return during the stroke, and after a
// collar at the end.
constexpr double kLeft = 4e-2, kLastLeft = 2e-5;
// A collar that returns less than this share of the pending volume has found no room.
constexpr double kNoRoom = 1e-3;

FieldVerb verb_of(Mode mode) {
  switch (mode) {
    case Mode::rasp:
      return FieldVerb::rasp;
    case Mode::fill:
      return FieldVerb::fill;
    case Mode::inflate:
      return FieldVerb::inflate;
    case Mode::flatten:
      return FieldVerb::flatten;
    case Mode::trim:
      return FieldVerb::trim;
    case Mode::build:
      return FieldVerb::build;
    default:
      return FieldVerb::smooth;
  }
}
WarpVerb warp_of(Mode mode) {
  switch (mode) {
    case Mode::nudge:
      return WarpVerb::nudge;
    case Mode::twist:
      return WarpVerb::twist;
    case Mode::bend:
      return WarpVerb::bend;
    case Mode::pinch:
      return WarpVerb::pinch;
    case Mode::scale:
      return WarpVerb::scale;
    case Mode::node:
      return WarpVerb::node;
    default:
      return WarpVerb::grab;
  }
}

double cubed(double x) { return x * x * x; }

}  // namespace

Status check_brush_of(Mode mode, const Brush& brush) {
  return check_brush(brush, mode == Mode::inflate ? FieldVerb::inflate : FieldVerb::smooth);
}

double default_strength(Mode mode) { return warps(mode) || mode == Mode::paint ? 1 : 0.5; }

double tool_radius_mm(const Tool& tool) {
  double radius = 0;
  for_tool_numbers(tool, [&](std::string_view key, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Vec3>)
      radius = 0.5 * value.maxCoeff();
    else if (key == "radius")
      radius = value;
    else if (key == "ks")  // radius 2 mm above the tip
      radius = std::sqrt(2 / value);
  });
  return radius;
}

double press_radius_mm(const Tool& tool, double pitch_mm) {
  return std::clamp(2.5 * tool_radius_mm(tool), 8 * pitch_mm, 96 * pitch_mm);
}

Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s, double rate_hz,
                double full_speed_mm_s) {
  if (law.model == ForceModel::paper) return -work_per_mm / rate_hz * velocity_mm_s;
  const double speed = std::sqrt(velocity_mm_s.squaredNorm());
  return -work_per_mm / std::max(speed, full_speed_mm_s) * velocity_mm_s;
}

Status ReshapeStroke::begin(const ReshapeSettings& settings, const std::vector<Material>& materials,
                            const Pose& start) {
  KIBORI_CHECK(!materials.empty());
  if (!reshapes(settings.mode)) return Error{"a dab needs a mode that reshapes"};
  if (Status fine = check_brush_of(settings.mode, settings.brush); !fine) return fine;
  settings_ = settings;
  materials_ = &materials;
  images_ = SymmetryImages(settings.symmetry);
  edit_.set_symmetry(settings.symmetry);
  edit_.forget();
  start_ = last_ = computed_at_ = start;
  held_ = {};
  to_next_mm_ = settings.mode == Mode::press ? spacing_mm() : 0;
  plane_.reset();
  pending_mm3_ = pressed_mm3_ = missed_mm3_ = 0;
  direction_ = Vec3::Zero();
  turn_rad_ = computed_turn_rad_ = 0;
  computed_ = true;
  warped_ = {};
  stiffness_n_mm_ = 0;
  pull_.begin();
  met_ = start;
  if (on_wheel(settings.mode)) wheel_.begin(centre_of(model_.lattice()), settings.tool, start);
  if (!warps(settings.mode)) return Ok{};
  warp_.begin();
  normal_ = start.axis();
  if (const auto under = memory_->reshaper.surface_under(model_, settings.brush, start.tip)) {
    normal_ = under->plane.normal;
    stiffness_n_mm_ = kPullShare * settings.law.hand_share * material(under->material).u *
                      settings.brush.radius_mm;
    material_ = under->material;
  }
  return Ok{};
}

double ReshapeStroke::spacing_mm() const {
  const double pitch = model_.lattice().pitch_mm;
  if (on_wheel(settings_.mode)) return kWheelSpacing * pitch;
  return std::max(settings_.mode == Mode::press
                      ? kPressSpacing * press_radius_mm(settings_.tool, pitch)
                      : settings_.brush.spacing * settings_.brush.radius_mm,
                  kMinSpacing * pitch);
}

// Adds the resistance of a dab to the sums.
void ReshapeStroke::hold(const Reshaped& what, const Vec3& centre, Sums& sums) const {
  sums.added += what.added_mm3;
  sums.removed += what.removed_mm3;
  sums.points += what.points;
  sums.clipped |= what.clipped;
  for (size_t i = 0; i < what.parts.size(); i++) {
    const Reshaped::Part& part = what.parts[i];
    if (!(part.share > 0)) continue;
    const Material& of = material(static_cast<int>(i));
    const double work =
        what.own * (settings_.law.model == ForceModel::paper
                        ? of.kf * static_cast<double>(what.points)
                        : settings_.law.hand_share * of.u * (what.added_mm3 + what.removed_mm3));
    sums.held.work_per_mm += part.share * work;
    sums.held.lever += work * (part.sum_mm - part.share * centre);
  }
}

Status ReshapeStroke::dab(const Vec3& centre, Sums& sums) {
  const Mode mode = settings_.mode;
  const Brush& brush = settings_.brush;
  if (mode == Mode::crease) return crease(centre, sums);
  if (mode == Mode::paint) {
    std::vector<Vec3> centres{centre};
    for (const SymmetryImage& image : images_)
      centres.push_back(image_of(centre, images_.centre_mm(), image));
    const Result<int64_t> painted = paint_dab(model_, brush, centres, *materials_);
    return painted ? Status(Ok{}) : Status(Error{painted.error()});
  }
  if (to_plane(mode) && brush.flatten_to == FlattenTo::stroke && !plane_)
    if (const auto under = memory_->reshaper.surface_under(model_, brush, centre))
      plane_ = under->plane;
  std::optional<FlatPlane> plane = plane_;
  if (to_plane(mode) && brush.flatten_to == FlattenTo::plane) plane = brush.plane;
  std::vector<DabPlace> places{{centre, plane}};
  for (const SymmetryImage& image : images_) {
    DabPlace place{image_of(centre, images_.centre_mm(), image), plane};
    if (plane)
      place.plane = FlatPlane{image_of(plane->point_mm, images_.centre_mm(), image),
                              image.turn * plane->normal};
    places.push_back(place);
  }
  const Result<Reshaped> done =
      memory_->reshaper.dab(model_, verb_of(mode), brush, places, missed_mm3_);
  if (!done) return Error{done.error()};
  if (mode == Mode::smooth && brush.keep_volume)
    missed_mm3_ += done.value().removed_mm3 - done.value().added_mm3;
  hold(done.value(), centre, sums);
  return Ok{};
}

// Pulls the surface together and sinks its centre.
Status ReshapeStroke::crease(const Vec3& centre, Sums& sums) {
  Brush brush = settings_.brush;
  const double pull = kCreasePinch * brush.strength;
  std::vector<Drag> pinches;
  std::vector<DabPlace> places;
  const auto put = [&](const Vec3& at) {
    Drag drag;
    drag.centre = at;
    // This displacement pulls by exactly that share: see warp_map.h.
    drag.displacement = pull / (1 - pull) * brush.radius_mm * Vec3::UnitZ();
    pinches.push_back(drag);
    places.push_back({at, {}});
  };
  put(centre);
  for (const SymmetryImage& image : images_) put(image_of(centre, images_.centre_mm(), image));
  brush.strength = 1;
  warp_.begin();
  Result<Reshaped> pinched = warp_.warp(WarpVerb::pinch, brush, pinches);
  if (!pinched) return Error{pinched.error()};
  sums.added += pinched.value().added_mm3;
  sums.removed += pinched.value().removed_mm3;
  sums.points += pinched.value().points;
  sums.clipped |= pinched.value().clipped;
  brush.strength = -settings_.brush.strength;
  if (!(brush.sigma_mm > 0)) brush.sigma_mm = kCreaseDepth * brush.radius_mm;
  brush.radius_mm *= kCreaseWidth;
  const Result<Reshaped> sunk = memory_->reshaper.dab(model_, FieldVerb::inflate, brush, places);
  if (!sunk) return Error{sunk.error()};
  hold(sunk.value(), centre, sums);
  return Ok{};
}

std::vector<Drag> ReshapeStroke::drags() const {
  Drag drag;
  drag.centre = start_.tip;
  drag.axis = start_.axis();
  drag.normal = normal_;
  drag.displacement = last_.tip - start_.tip;
  drag.turn_rad = turn_rad_;
  std::vector<Drag> all{drag};
  for (const SymmetryImage& image : images_)
    all.push_back({image_of(drag.centre, images_.centre_mm(), image), image.turn * drag.axis,
                   image.turn * drag.normal, image.turn * drag.displacement,
                   (image.mirrors ? -1 : 1) * drag.turn_rad});
  return all;
}

Status ReshapeStroke::compute_warp(Sums& sums) {
  if (computed_) return Ok{};
  const Result<Reshaped> done = warp_.warp(warp_of(settings_.mode), settings_.brush, drags());
  if (!done) return Error{done.error()};
  const Reshaped& what = done.value();
  const double grown =
      (what.added_mm3 - what.removed_mm3) - (warped_.added_mm3 - warped_.removed_mm3);
  (grown > 0 ? sums.added : sums.removed) += std::fabs(grown);
  const int64_t points = std::abs(what.points - warped_.points);
  sums.points += points;
  sums.clipped |= what.clipped;
  if (settings_.law.model == ForceModel::paper) {
    const double displacement = (last_.tip - computed_at_.tip).norm(),
                 own = static_cast<double>(points) / static_cast<double>(1 + images_.size());
    held_ = {};
    if (displacement > 0) held_.work_per_mm = material(material_).kf * own / displacement;
  }
  warped_ = what;
  computed_ = true;
  computed_at_ = last_;
  computed_turn_rad_ = turn_rad_;
  return Ok{};
}

// Returns pending material around the tool and its images, in at most kCollars collars. Each collar
// is `wider` times the tool's own. Stops when the pending volume is below `until` of the pressed
// volume, or below `left` of the pending volume before.
Status ReshapeStroke::give_back(double until, double left, double wider, Sums& sums) {
  const double radius = wider * press_radius_mm(settings_.tool, model_.lattice().pitch_mm);
  std::vector<PressingTool> tools{{last_, direction_, middle_}};
  for (const SymmetryImage& image : images_)
    tools.push_back({image_of(last_, settings_.tool, images_.centre_mm(), image),
                     image.turn * direction_, image_of(middle_, images_.centre_mm(), image)});
  const double enough = std::max(until * pressed_mm3_, left * std::fabs(pending_mm3_));
  for (int collar = 0; collar < kCollars && std::fabs(pending_mm3_) > enough; collar++) {
    const double before = pending_mm3_;
    for (size_t i = 0; i < tools.size(); i++) {
      const Result<Reshaped> raised =
          memory_->clay.raise(model_, settings_.tool, tools, i, radius,
                              pending_mm3_ / static_cast<double>(tools.size() - i), 0.5 * left);
      if (!raised) return Error{raised.error()};
      const double back = raised.value().added_mm3 - raised.value().removed_mm3;
      pending_mm3_ -= back;
      sums.added += back;
      sums.points += raised.value().points;
    }
    if (std::fabs(pending_mm3_) > (1 - kNoRoom) * std::fabs(before)) break;
  }
  return Ok{};
}

Status ReshapeStroke::press(const ToolMotion& motion, const Pose& end, Sums& sums) {
  const Lattice& lattice = model_.lattice();
  const Result<int> substeps = substeps_of(settings_.tool, motion, lattice);
  if (!substeps) return Error{substeps.error()};
  Removed own;
  edit_.run(settings_.tool, motion, end, substeps.value(), false, 0, threads_, own);
  const double cell = cubed(lattice.pitch_mm);
  double volume = 0;
  Vec3 sum = Vec3::Zero();
  own.for_parts([&](int i, const RemovedPart& part) {
    const double here = part.volume() * cell;
    const Vec3 lever = part.moment * (cell * lattice.pitch_mm);
    volume += here;
    sum += lever;
    // Factor 2: displaced material returns, so the work is u (removed + added).
    const Material& of = material(i);
    const double work = settings_.law.model == ForceModel::paper
                            ? of.kf * static_cast<double>(part.points)
                            : 2 * settings_.law.hand_share * of.u * here;
    sums.held.work_per_mm += work;
    if (here > 0) sums.held.lever += work * lever / here;
  });
  if (volume > 0) {
    middle_ = end.tip + sum / volume;
    const double displacement = std::sqrt(motion.travel_mm.squaredNorm());
    if (displacement > 0) direction_ = motion.travel_mm / displacement;
  }
  const double all = volume + edit_.images().volume() * cell;
  pending_mm3_ += all;
  pressed_mm3_ += all;
  sums.removed += all;
  sums.points += own.points() + edit_.images().points();
  return Ok{};
}

// Presses piece by piece, from one return of material to the next.
Status ReshapeStroke::press_along(const ToolMotion& motion, const Pose& end, Sums& sums) {
  const double length = std::sqrt(motion.travel_mm.squaredNorm());
  ToolMotion piece{motion.start, Vec3::Zero(), Vec3::Zero()};
  const auto press_to = [&](const Pose& there, double share) {
    piece.travel_mm = there.tip - piece.start.tip;
    piece.turn_rad = share * motion.turn_rad;
    Status done = press(piece, there, sums);
    piece.start = there;
    return done;
  };
  double at = 0;
  while (length - at >= to_next_mm_) {
    at += to_next_mm_;
    last_ = motion.at(at / length);
    if (Status done = press_to(last_, to_next_mm_ / length); !done) return done;
    if (Status done = give_back(kPendingShare, kLeft, 1, sums); !done) return done;
    to_next_mm_ = spacing_mm();
  }
  to_next_mm_ -= length - at;
  last_ = end;
  if (Status done = press_to(end, length > 0 ? (length - at) / length : 1); !done) return done;
  if (length > 0) held_ = {sums.held.work_per_mm / length, sums.held.lever / length};
  return Ok{};
}

// Moves the tool to `end`, where the profile meets it.
Status ReshapeStroke::turn_to(const Pose& end, Sums& sums) {
  const Vec3 displacement = end.tip - met_.tip;
  const Result<Wheel::Turned> done =
      wheel_.advance(settings_.mode == Mode::turn ? WheelVerb::turn : WheelVerb::throw_clay,
                     settings_.tool, {met_.tip, end.frame}, displacement, settings_.brush.wall_mm);
  if (!done) return Error{done.error()};
  const auto& [what, pressed] = done.value();
  sums.clipped |= what.clipped;
  sums.added += what.added_mm3;
  sums.removed += what.removed_mm3;
  sums.points += what.points;
  sums.dabs++;
  // The met material resists, wherever it moves then. The wheel supports most of the force, a lathe
  // nearly all.
  const Material& of = material(wheel_.profile().material);
  const double share = std::min(settings_.law.hand_share,
                                settings_.mode == Mode::turn ? kLatheShare : kPoweredShare);
  sums.held.work_per_mm += settings_.law.model == ForceModel::paper
                               ? of.kf * static_cast<double>(what.points)
                               : share * of.u * pressed;
  met_ = end;
  return Ok{};
}

Status ReshapeStroke::advance(ToolTick& tick, bool now) {
  KIBORI_CHECK(materials_);
  const Mode mode = settings_.mode;
  const Pose from = last_;
  const Vec3 displacement = tick.pose.tip - from.tip;
  const double length = std::sqrt(displacement.squaredNorm()), spacing = spacing_mm();
  if (!(length <= kMaxDabs * spacing))
    return Error{"one tick would need more than 10000 dabs of this brush; move slower"};
  last_ = tick.pose;
  Sums sums;
  if (warps(mode)) {
    turn_rad_ += tick.motion.turn.dot(start_.axis());
    computed_ &= length == 0 && turn_rad_ == computed_turn_rad_;
    if (now || (last_.tip - computed_at_.tip).norm() >= spacing ||
        std::fabs(turn_rad_ - computed_turn_rad_) >= kTurnBetween)
      if (Status done = compute_warp(sums); !done) return done;
  } else if (mode == Mode::press) {
    if (Status done = press_along({from, displacement, tick.motion.turn}, tick.pose, sums); !done)
      return done;
  } else {
    double at = to_next_mm_;
    const ToolMotion whole{from, displacement, tick.motion.turn};
    for (; on_wheel(mode) && at <= length; at += spacing)
      if (Status done = turn_to(length > 0 ? whole.at(at / length) : from, sums); !done)
        return done;
    for (; !on_wheel(mode) && at <= length; at += spacing, sums.dabs++)
      if (Status done =
              dab(length > 0 ? Vec3(from.tip + (at / length) * displacement) : from.tip, sums);
          !done)
        return done;
    to_next_mm_ = at - length;
  }
  finish_tick(sums, displacement, tick);
  return Ok{};
}

Status ReshapeStroke::end(ToolTick& tick) {
  Sums sums;
  if (warps(settings_.mode)) {
    if (Status done = compute_warp(sums); !done) return done;
  } else if (on_wheel(settings_.mode)) {
    if (Status done = turn_to(last_, sums); !done) return done;
  } else if (settings_.mode == Mode::press) {
    double wider = 1;
    for (int i = 0; i < kLastCollars && std::fabs(pending_mm3_) > kLastPendingShare * pressed_mm3_;
         i++) {
      const double before = pending_mm3_;
      if (Status done = give_back(kLastPendingShare, kLastLeft, wider, sums); !done) return done;
      if (std::fabs(pending_mm3_) > (1 - kNoRoom) * std::fabs(before)) {
        if (wider >= kWidest) break;
        wider *= kWiden;
      }
    }
  }
  tick.removed_mm3 += sums.removed - sums.added;
  tick.points += sums.points;
  return Ok{};
}

Status ReshapeStroke::break_off() {
  Sums sums;
  return warps(settings_.mode) ? compute_warp(sums) : Status(Ok{});
}

void ReshapeStroke::finish_tick(const Sums& sums, const Vec3& displacement, ToolTick& tick) {
  const ForceLaw& law = settings_.law;
  if (sums.dabs > 0) {
    held_.work_per_mm = sums.held.work_per_mm / (sums.dabs * spacing_mm());
    held_.lever = sums.held.lever / (sums.dabs * spacing_mm());
  }
  tick.points += sums.points;
  tick.removed_mm3 = sums.removed - sums.added;
  tick.clipped |= sums.clipped;
  tick.edited = true;
  if (warps(settings_.mode) && law.model != ForceModel::paper) {
    tick.wrench = {pull_.pull(stiffness_n_mm_, displacement, 1 / settings_.rate_hz), Vec3::Zero()};
    return;
  }
  // Force for one unit of work per mm.
  const Vec3 against = held_force(law, 1, displacement * settings_.rate_hz, settings_.rate_hz);
  tick.wrench.force = held_.work_per_mm * against;
  const Vec3 axis = tick.pose.axis();
  const Vec3 lever = law.dof == 6 ? held_.lever : Vec3(held_.lever.dot(axis) * axis);
  tick.wrench.moment = lever.cross(against);
}

}  // namespace kibori
