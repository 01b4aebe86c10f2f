// SPDX-License-Identifier: MIT
#include <kibori/motion/reshape_stroke.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/check.h>
#include <kibori/reshape/paint_dab.h>

namespace kibori {
namespace {

// Dabs lie at least this much apart [cells].
constexpr double kLeastSpacing = 0.5;

// A dab of a crease draws what is about it together by this share of its distance, and sinks it by
// this share of the brush's radius, within that share of the radius; all at full strength. About
// four dabs pinch each place and two sink it, so that a stroke at half strength leaves a valley a
// fifth of a radius deep.
constexpr double kCreasePinch = 0.2, kCreaseDepth = 0.2, kCreaseWidth = 0.5;

// A warp is computed again when the hand turned so far [rad].
constexpr double kTurnBetween = 0.1;

// What a warp pulls with, of the specific cutting energy times the brush's radius: so that a quick
// pull in clay is felt as some newtons, and in oak with all a hand has.
constexpr double kPullShare = 0.1;

// Presses give back so often [of the tool's radius of collar]; so many collars each time, and at a
// stroke's end.
constexpr double kPressSpacing = 0.1;
constexpr int kCollars = 3, kLastCollars = 40;
// Each collar at the end reaches farther by this factor, up to so many times the first's radius.
constexpr double kWiden = 1.2, kWidest = 4;
// A profile meets the tool this often [cells of the tip's way]: the whole body is told anew each
// time.
constexpr double kWheelSpacing = 1;
// Of a lathe's cut the hand bears about as much as it feeds slower than the rim turns: tens of mm
// to metres a second.
constexpr double kLatheShare = 0.01;
// What may stay owed on the way and at the end, of what was pressed.
constexpr double kOwedShare = 4e-3, kLastOwedShare = 1e-6;
// What one giving back on the way may leave, and at the end a collar, of what is owed.
constexpr double kLeft = 4e-2, kLastLeft = 2e-5;
// A collar that brings back less than this of what is owed has no room.
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
    else if (key == "ks")  // as wide as 2 mm above its tip
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
  owed_mm3_ = pressed_mm3_ = missed_mm3_ = 0;
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
                  kLeastSpacing * pitch);
}

// What a dab asks of the hand, into the sums.
void ReshapeStroke::hold(const Reshaped& what, const Vec3& centre, Sums& sums) const {
  sums.added += what.added_mm3;
  sums.removed += what.removed_mm3;
  sums.points += what.points;
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
  if (mode == Mode::flatten && brush.flatten_to == FlattenTo::stroke && !plane_)
    if (const auto under = memory_->reshaper.surface_under(model_, brush, centre))
      plane_ = under->plane;
  std::optional<FlatPlane> plane = plane_;
  if (mode == Mode::flatten && brush.flatten_to == FlattenTo::plane) plane = brush.plane;
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

// Draws the surface together, and sinks it where it is drawn to.
Status ReshapeStroke::crease(const Vec3& centre, Sums& sums) {
  Brush brush = settings_.brush;
  const double pull = kCreasePinch * brush.strength;
  std::vector<Drag> pinches;
  std::vector<DabPlace> places;
  const auto put = [&](const Vec3& at) {
    Drag drag;
    drag.centre = at;
    // As long as makes it that share: see warp_map.h.
    drag.way = pull / (1 - pull) * brush.radius_mm * Vec3::UnitZ();
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
  drag.way = last_.tip - start_.tip;
  drag.turn_rad = turn_rad_;
  std::vector<Drag> all{drag};
  for (const SymmetryImage& image : images_)
    all.push_back({image_of(drag.centre, images_.centre_mm(), image), image.turn * drag.axis,
                   image.turn * drag.normal, image.turn * drag.way,
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
    const double way = (last_.tip - computed_at_.tip).norm(),
                 own = static_cast<double>(points) / static_cast<double>(1 + images_.size());
    held_ = {};
    if (way > 0) held_.work_per_mm = material(material_).kf * own / way;
  }
  warped_ = what;
  computed_ = true;
  computed_at_ = last_;
  computed_turn_rad_ = turn_rad_;
  return Ok{};
}

// What is owed comes back around the tool and its images, as far as kCollars collars go, each
// `wider` than the tool asks; what may stay owed is a share `until` of what was pressed, or `left`
// of what is owed before.
Status ReshapeStroke::give_back(double until, double left, double wider, Sums& sums) {
  const double radius = wider * press_radius_mm(settings_.tool, model_.lattice().pitch_mm);
  std::vector<PressingTool> tools{{last_, direction_, middle_}};
  for (const SymmetryImage& image : images_)
    tools.push_back({image_of(last_, settings_.tool, images_.centre_mm(), image),
                     image.turn * direction_, image_of(middle_, images_.centre_mm(), image)});
  const double enough = std::max(until * pressed_mm3_, left * std::fabs(owed_mm3_));
  for (int collar = 0; collar < kCollars && std::fabs(owed_mm3_) > enough; collar++) {
    const double before = owed_mm3_;
    for (size_t i = 0; i < tools.size(); i++) {
      const Result<Reshaped> raised =
          memory_->clay.raise(model_, settings_.tool, tools, i, radius,
                              owed_mm3_ / static_cast<double>(tools.size() - i), 0.5 * left);
      if (!raised) return Error{raised.error()};
      const double back = raised.value().added_mm3 - raised.value().removed_mm3;
      owed_mm3_ -= back;
      sums.added += back;
      sums.points += raised.value().points;
    }
    if (std::fabs(owed_mm3_) > (1 - kNoRoom) * std::fabs(before)) break;
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
    const double here = part.mean_volume() * cell;
    const Vec3 lever =
        (part.moment[0] + part.moment[1] + part.moment[2]) / 3 * (cell * lattice.pitch_mm);
    volume += here;
    sum += lever;
    // What is pressed away comes back: u (removed + added).
    const Material& of = material(i);
    const double work = settings_.law.model == ForceModel::paper
                            ? of.kf * static_cast<double>(part.points)
                            : 2 * settings_.law.hand_share * of.u * here;
    sums.held.work_per_mm += work;
    if (here > 0) sums.held.lever += work * lever / here;
  });
  if (volume > 0) {
    middle_ = end.tip + sum / volume;
    const double way = std::sqrt(motion.travel_mm.squaredNorm());
    if (way > 0) direction_ = motion.travel_mm / way;
  }
  const double all = volume + edit_.images().mean_volume() * cell;
  owed_mm3_ += all;
  pressed_mm3_ += all;
  sums.removed += all;
  sums.points += own.points() + edit_.images().points();
  return Ok{};
}

// Piece by piece, from one giving back to the next.
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
    if (Status done = give_back(kOwedShare, kLeft, 1, sums); !done) return done;
    to_next_mm_ = spacing_mm();
  }
  to_next_mm_ -= length - at;
  last_ = end;
  if (Status done = press_to(end, length > 0 ? (length - at) / length : 1); !done) return done;
  if (length > 0) held_ = {sums.held.work_per_mm / length, sums.held.lever / length};
  return Ok{};
}

// The profile meets the tool on its way to there.
Status ReshapeStroke::turn_to(const Pose& end, Sums& sums) {
  const Vec3 way = end.tip - met_.tip;
  const Result<Wheel::Turned> done =
      wheel_.advance(settings_.mode == Mode::turn ? WheelVerb::turn : WheelVerb::throw_clay,
                     settings_.tool, {met_.tip, end.frame}, way, settings_.brush.wall_mm);
  if (!done) return Error{done.error()};
  const auto& [what, pressed] = done.value();
  sums.clipped |= what.clipped;
  sums.added += what.added_mm3;
  sums.removed += what.removed_mm3;
  sums.points += what.points;
  sums.dabs++;
  // What the tool meets resists, wherever it then goes; the wheel bears most of it, a lathe nearly
  // all.
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
  const Vec3 way = tick.pose.tip - from.tip;
  const double length = std::sqrt(way.squaredNorm()), spacing = spacing_mm();
  if (!(length <= kMaxDabs * spacing))
    return Error{"one tick's way holds more than 10000 dabs of this brush; move slower"};
  last_ = tick.pose;
  Sums sums;
  if (warps(mode)) {
    turn_rad_ += tick.motion.turn.dot(start_.axis());
    computed_ &= length == 0 && turn_rad_ == computed_turn_rad_;
    if (now || (last_.tip - computed_at_.tip).norm() >= spacing ||
        std::fabs(turn_rad_ - computed_turn_rad_) >= kTurnBetween)
      if (Status done = compute_warp(sums); !done) return done;
  } else if (mode == Mode::press) {
    if (Status done = press_along({from, way, tick.motion.turn}, tick.pose, sums); !done)
      return done;
  } else {
    double at = to_next_mm_;
    const ToolMotion whole{from, way, tick.motion.turn};
    for (; on_wheel(mode) && at <= length; at += spacing)
      if (Status done = turn_to(length > 0 ? whole.at(at / length) : from, sums); !done)
        return done;
    for (; !on_wheel(mode) && at <= length; at += spacing, sums.dabs++)
      if (Status done = dab(length > 0 ? Vec3(from.tip + (at / length) * way) : from.tip, sums);
          !done)
        return done;
    to_next_mm_ = at - length;
  }
  finish_tick(sums, way, tick);
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
    for (int i = 0; i < kLastCollars && std::fabs(owed_mm3_) > kLastOwedShare * pressed_mm3_; i++) {
      const double before = owed_mm3_;
      if (Status done = give_back(kLastOwedShare, kLastLeft, wider, sums); !done) return done;
      if (std::fabs(owed_mm3_) > (1 - kNoRoom) * std::fabs(before)) {
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

void ReshapeStroke::finish_tick(const Sums& sums, const Vec3& way, ToolTick& tick) {
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
    tick.wrench = {pull_.pull(stiffness_n_mm_, way, 1 / settings_.rate_hz), Vec3::Zero()};
    return;
  }
  // Of a unit of work per mm.
  const Vec3 against = held_force(law, 1, way * settings_.rate_hz, settings_.rate_hz);
  tick.wrench.force = held_.work_per_mm * against;
  const Vec3 axis = tick.pose.axis();
  const Vec3 lever = law.dof == 6 ? held_.lever : Vec3(held_.lever.dot(axis) * axis);
  tick.wrench.moment = lever.cross(against);
}

}  // namespace kibori
