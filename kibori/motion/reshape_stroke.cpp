// SPDX-License-Identifier: MIT
#include <kibori/motion/reshape_stroke.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include <kibori/base/check.h>
#include <kibori/reshape/paint_dab.h>

namespace kibori {
namespace {

// Minimum distance between dabs [cells].
constexpr double kMinSpacing = 0.5;
// Minimum radius of a brush that follows the pressure of a pen [cells], if it is not smaller at full
// pressure. A smaller dab changes only single nodes.
constexpr double kMinPressedCells = 2;
// A texture's direction is that from a point that trails behind the tip, to the tip. This is the
// distance between the two, as a share of the radius.
constexpr double kAlphaTrail = 0.5;

// One dab of a crease at full strength. It draws points towards the centre by the share
// kCreasePinch of their distance. It lowers the surface by kCreaseDepth of the brush's radius,
// within kCreaseWidth of that radius. In a stroke, about four dabs draw each place together, and
// two lower it. So at half strength, the valley is a fifth of a radius deep.
constexpr double kCreasePinch = 0.2, kCreaseDepth = 0.2, kCreaseWidth = 0.5;

// A warp is computed again after the hand turned by this angle [rad].
constexpr double kTurnBetween = 0.1;

// Stiffness of a warp's pull, as a share of u times the brush's radius. A quick pull in clay gives
// a force of some newtons; in oak it needs a hand's full strength.
constexpr double kPullShare = 0.1;

// Distance between two returns of pressed material, as a share of the collar's radius.
constexpr double kPressSpacing = 0.1;
// Maximum number of collars in a return, and of returns at a stroke's end.
constexpr int kCollars = 3, kLastCollars = 40;
// At a stroke's end, the collar's radius grows by this factor if a return finds no room. Then the
// maximum of the radius, relative to the first.
constexpr double kWiden = 1.2, kWidest = 4;
// Each time the tip has moved this far [cells], the tool changes the profile, and the whole body is
// rebuilt.
constexpr double kWheelSpacing = 1;
// Share of a lathe's cutting force that the hand supports. It is about the ratio of the feed to the
// speed of the rim: tens of mm/s to metres per second.
constexpr double kLatheShare = 0.01;
// Share of the pressed volume that may stay pending during the stroke, and at its end.
constexpr double kPendingShare = 4e-3, kLastPendingShare = 1e-6;
// Share of the pending volume that may remain after a return: during the stroke, and at its end.
constexpr double kLeft = 4e-2, kLastLeft = 2e-5;
// A collar or return that returns less than this share of the pending volume has found no room.
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
    case Mode::grab_connected:
      return WarpVerb::grab_connected;
    default:
      return WarpVerb::grab;
  }
}

double cubed(double x) { return x * x * x; }

// Offset of a stroke's texture along the path, from 0 to 1: random, but the same in a replay.
double random_shift(const Vec3& start) {
  uint64_t bits = 0;
  for (int i = 0; i < 3; i++)
    bits = (bits ^ std::bit_cast<uint64_t>(start[i])) * 0x9e3779b97f4a7c15u;
  return static_cast<double>(bits >> 40) / static_cast<double>(1 << 24);
}

}  // namespace

Status check_brush_of(Mode mode, const Brush& brush) {
  return check_brush(brush, has_opposite(mode));
}

double default_strength(Mode mode) {
  return pulls(mode) || mode == Mode::paint || mode == Mode::mask ? 1 : 0.5;
}

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
  brush_ = settings.brush;
  materials_ = &materials;
  images_ = SymmetryImages(settings.symmetry);
  edit_.set_symmetry(settings.symmetry);
  edit_.forget();
  start_ = last_ = computed_at_ = start;
  held_ = {};
  to_next_mm_ = settings.mode == Mode::press || needs_direction() ? spacing_mm() : 0;
  trail_ = start.tip;
  shift_ = random_shift(start.tip);
  hooked_mm_ = start.tip;
  has_dab_ = false;
  pressure_.reset();
  plane_.reset();
  pending_mm3_ = pressed_mm3_ = missed_mm3_ = 0;
  direction_ = Vec3::Zero();
  turn_rad_ = computed_turn_rad_ = 0;
  computed_ = true;
  warped_ = {};
  stiffness_n_mm_ = 0;
  pull_.begin();
  met_ = start;
  warp_.set_grows(settings.grows);
  wheel_.set_grows(settings.grows);
  if (on_wheel(settings.mode)) wheel_.begin(centre_of(model_.lattice()), settings.tool, start);
  if (!pulls(settings.mode)) return Ok{};
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
                      : brush_.spacing * brush_.radius_mm,
                  kMinSpacing * pitch);
}

// Changes the brush of the next dab by the pressure of a pen.
void ReshapeStroke::press_brush(double pressure) {
  const Brush& full = settings_.brush;
  if (full.pressure == PressureUse::none) return;
  const bool hooks = settings_.mode == Mode::snake_hook;
  if (full.pressure != PressureUse::strength)
    brush_.radius_mm =
        std::max({pressure, kMinPressedSize,
                  std::min(1.0, kMinPressedCells * model_.lattice().pitch_mm / full.radius_mm)}) *
        full.radius_mm;
  if (full.pressure != PressureUse::size && !hooks) brush_.strength = pressure * full.strength;
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

// Applies a dab. If the lattice's border cuts it off and the lattice may grow, applies it again in
// a larger lattice.
Result<Reshaped> ReshapeStroke::dab_with_room(FieldVerb verb, const Brush& brush,
                                              const std::vector<DabPlace>& places,
                                              double missed_mm3) {
  const Lattice& lattice = model_.lattice();
  Box need = lattice.whole().units;
  const Vec3 reach = Vec3::Constant(brush.radius_mm / lattice.pitch_mm + 1);
  for (const DabPlace& place : places) {
    const Vec3 at = lattice.to_lattice(place.centre_mm).units;
    need.include(Box{at - reach, at + reach});
  }
  std::optional<Snapshot> before;
  if (settings_.grows && need.min.allFinite() && need.max.allFinite() &&
      need.size() != lattice.whole().units.size())
    before = model_.snapshot();
  Result<Reshaped> done = memory_->reshaper.dab(model_, verb, brush, places, missed_mm3);
  if (!done || !done.value().clipped || !before) return done;
  const Lattice larger = grown_to(lattice, {need});
  if (larger.whole().units.size() == lattice.whole().units.size()) return done;
  model_.restore(*before);
  before.reset();
  model_.set_lattice(larger);
  return memory_->reshaper.dab(model_, verb, brush, places, missed_mm3);
}

Status ReshapeStroke::dab(const Vec3& centre, Sums& sums) {
  const Mode mode = settings_.mode;
  const Brush& brush = brush_;
  has_dab_ = true;
  if (mode == Mode::crease) return crease(centre, sums);
  if (mode == Mode::snake_hook) return hook(centre, sums);
  const AlphaFrame alpha = alpha_frame(centre);
  std::vector<DabPlace> places{{centre, {}, alpha}};
  for (const SymmetryImage& image : images_)
    places.push_back({image_of(centre, images_.centre_mm(), image),
                      {},
                      {image.turn * alpha.along, image.turn * alpha.across, alpha.shift}});
  if (mode == Mode::paint || mode == Mode::mask) {
    const Result<int64_t> painted = mode == Mode::mask
                                        ? mask_dab(model_, brush, places)
                                        : paint_dab(model_, brush, places, *materials_);
    return painted ? Status(Ok{}) : Status(Error{painted.error()});
  }
  if (to_plane(mode) && brush.flatten_to == FlattenTo::stroke && !plane_)
    if (const auto under = memory_->reshaper.surface_under(model_, brush, centre))
      plane_ = under->plane;
  std::optional<FlatPlane> plane = plane_;
  if (to_plane(mode) && brush.flatten_to == FlattenTo::plane) plane = brush.plane;
  if (plane) {
    places[0].plane = plane;
    for (size_t i = 0; i < images_.size(); i++) {
      const SymmetryImage& image = images_.begin()[i];
      places[i + 1].plane = FlatPlane{image_of(plane->point_mm, images_.centre_mm(), image),
                                      image.turn * plane->normal};
    }
  }
  const Result<Reshaped> done = dab_with_room(verb_of(mode), brush, places, missed_mm3_);
  if (!done) return Error{done.error()};
  if (mode == Mode::smooth && brush.keep_volume)
    missed_mm3_ += done.value().removed_mm3 - done.value().added_mm3;
  hold(done.value(), centre, sums);
  return Ok{};
}

// Directions and offset of the brush's texture at a dab. It runs along the path, and continues the
// texture of the last dab.
AlphaFrame ReshapeStroke::alpha_frame(const Vec3& centre) {
  AlphaFrame frame;
  const Brush& brush = brush_;
  if (!has_texture()) return frame;
  const Vec3 drawn = centre - trail_;
  const double length = drawn.norm(), string = kAlphaTrail * brush.radius_mm;
  if (length > string) trail_ = centre - drawn * (string / length);
  const Vec3 normal = last_.axis();
  frame.along = drawn - drawn.dot(normal) * normal;
  const double along = frame.along.norm();
  frame.along = along > 0 ? Vec3(frame.along / along) : Vec3(last_.frame.col(0));
  frame.across = normal.cross(frame.along);
  frame.shift = shift_;
  shift_ += 0.5 * spacing_mm() / brush.radius_mm;
  return frame;
}

// Pulls the surface from the place of the last dab to `centre`. So the pulled strand follows the
// tool, and the surface behind the brush stays in place.
Status ReshapeStroke::hook(const Vec3& centre, Sums& sums) {
  Drag drag;
  drag.centre = hooked_mm_;
  drag.displacement = centre - hooked_mm_;
  hooked_mm_ = centre;
  warp_.begin();
  const Result<Reshaped> pulled = warp_.warp(WarpVerb::hook, brush_, with_images(drag));
  if (!pulled) return Error{pulled.error()};
  const Reshaped& what = pulled.value();
  sums.added += what.added_mm3;
  sums.removed += what.removed_mm3;
  sums.points += what.points;
  sums.clipped |= what.clipped;
  if (settings_.law.model == ForceModel::paper)
    sums.held.work_per_mm += material(material_).kf * static_cast<double>(what.points) /
                             static_cast<double>(1 + images_.size());
  return Ok{};
}

// Pulls the surface together and sinks its centre. A negative strength raises it.
Status ReshapeStroke::crease(const Vec3& centre, Sums& sums) {
  Brush brush = brush_;
  brush.alpha = Alpha::none;
  const double pull = kCreasePinch * std::fabs(brush.strength);
  std::vector<Drag> pinches;
  std::vector<DabPlace> places;
  const auto put = [&](const Vec3& at) {
    Drag drag;
    drag.centre = at;
    // With this displacement, the pinch pulls by exactly the share `pull` (warp_map.h).
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
  brush.strength = -brush_.strength;
  if (!(brush.sigma_mm > 0)) brush.sigma_mm = kCreaseDepth * brush.radius_mm;
  brush.radius_mm *= kCreaseWidth;
  const Result<Reshaped> sunk = dab_with_room(FieldVerb::inflate, brush, places);
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
  return with_images(drag);
}

std::vector<Drag> ReshapeStroke::with_images(const Drag& drag) const {
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

// Returns pending material around the tool and its images, in at most kCollars collars. Their
// radius is `wider` times press_radius_mm. Stops when the pending volume is below the share `until`
// of the pressed volume, or below the share `left` of the pending volume before.
Status ReshapeStroke::give_back(double until, double left, double wider, Sums& sums) {
  const double radius = wider * press_radius_mm(settings_.tool, model_.lattice().pitch_mm);
  std::vector<PressingTool> tools{{last_, direction_, middle_}};
  for (const SymmetryImage& image : images_)
    tools.push_back({image_of(last_, settings_.tool, images_.centre_mm(), image),
                     image.turn * direction_, image_of(middle_, images_.centre_mm(), image)});
  if (settings_.grows)
    for (const PressingTool& tool : tools) {
      const Vec3 reach = Vec3::Constant(radius);
      model_.grow_to(
          model_.lattice().to_lattice(Box{tool.middle_mm - reach, tool.middle_mm + reach}));
    }
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
    // Factor 2: the displaced material is removed and added again, so the work is u (removed +
    // added).
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

// Presses along the motion, in pieces. Pending material returns between two pieces.
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

// Moves the tool to `end` and changes the profile there.
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
  // All material that the tool meets causes a force, even if it only moves to another place. The
  // motor of a wheel supports most of the force, that of a lathe nearly all.
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
  // The first pull of a snake hook is a straight line from the stroke's beginning. Until then, only
  // the distance from there counts, and not the path.
  const bool starts_hook = mode == Mode::snake_hook && !has_dab_;
  const Vec3 moved = tick.pose.tip - last_.tip;
  const Pose from = starts_hook ? start_ : last_;
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
    const double before = pressure_.value_or(tick.pressure);
    for (; !on_wheel(mode) && at <= length; at += spacing_mm(), sums.dabs++) {
      const double share = length > 0 ? at / length : 0;
      press_brush(before + share * (tick.pressure - before));
      if (Status done = dab(length > 0 ? Vec3(from.tip + share * displacement) : from.tip, sums);
          !done)
        return done;
    }
    if (!starts_hook || has_dab_) to_next_mm_ = at - length;
  }
  pressure_ = tick.pressure;
  finish_tick(sums, moved, tick);
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
  if (pulls(settings_.mode) && law.model != ForceModel::paper) {
    tick.wrench = {pull_.pull(stiffness_n_mm_, displacement, 1 / settings_.rate_hz), Vec3::Zero()};
    return;
  }
  // The force of one unit of work per mm.
  const Vec3 against = held_force(law, 1, displacement * settings_.rate_hz, settings_.rate_hz);
  tick.wrench.force = held_.work_per_mm * against;
  const Vec3 axis = tick.pose.axis();
  const Vec3 lever = law.dof == 6 ? held_.lever : Vec3(held_.lever.dot(axis) * axis);
  tick.wrench.moment = lever.cross(against);
}

}  // namespace kibori
