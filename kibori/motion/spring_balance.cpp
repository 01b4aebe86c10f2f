// SPDX-License-Identifier: MIT
// SpringTool: material that the tool would reach, its resistance, and the balance with the spring.
#include <kibori/motion/spring_tick.h>

#include <algorithm>
#include <utility>

#include <kibori/edit/edit.h>

namespace kibori {

using namespace spring;

namespace {

// Tolerances of the balance: a share of the pull, and a distance [cells]. An error of a thousandth
// of the tool's displacement is also accepted.
constexpr double kBalanceShare = 3e-4;
constexpr double kBalanceError = 1e-4;
// A trial uses fewer substeps than a cut, by this factor. Then the outermost point of the tool
// deviates by up to 0.4 cells. With a larger factor, the tool detects walls that do not exist. With
// a smaller one, a tick of a turning tool takes ten times as long as that of a straight one.
constexpr int kTrialPieces = 4;
// Minimum cosine of the angle between the hand's motion and the chip's direction. Above it, the
// chip of the last cell of path is that of the hand's groove.
constexpr double kSameGroove = 0.95;

}  // namespace

// Calls f(solid, options, sign) for the straight substeps of the path up to `share`. A trial removes
// nothing, so material inside the tool where two substeps meet counts twice. Therefore f is also
// called for the tool at rest in these poses, with sign -1.
template <class F>
void SpringTool::for_sweeps(const Tick& tick, double share, F&& f) const {
  const Lattice& lattice = model_.lattice();
  const ToolMotion path = tick.motion.part(share);
  const Result<int> counted = substeps_of(tick.tool, path, lattice);
  // advance() has rejected motions with too many substeps.
  const int substeps = counted ? (counted.value() + kTrialPieces - 1) / kTrialPieces : 1;
  EditOptions options;
  options.motion = {lattice.to_lattice(path.at(1).tip), false, LatticeVector(), Vec3::Zero(),
                    path.start.axis()};
  for (int i = 0; i < substeps; i++) {
    const Pose begin = path.substep(i, substeps);
    f(SweptTool(tick.tool, begin, path.travel_mm / substeps, lattice, tick.clear && substeps == 1)
          .solid(),
      options, 1);
    if (i > 0) f(SweptTool(tick.tool, begin, Vec3::Zero(), lattice).solid(), options, -1);
  }
}

double SpringTool::reach_volume(const Tick& tick, double share, const Grain* grain, bool chip) {
  trial_.reset();
  const Vec3 weights = tick.weights();
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options, int sign) {
    options.motion.along = &weights;
    options.motion.chip = chip;
    options.motion.grain = grain;
    if (grain) options.motion.across2 = grain->across2(tick.motion.travel_mm);
    Removed& sums = sign > 0 ? trial_ : twice_;
    if (sign < 0) twice_.reset();
    if (tick.mode == Mode::deposit)
      deposit_contact(model_, solid, tick.material, options, sums);
    else
      contact(model_, solid, options, sums);
    if (sign < 0) trial_.add(twice_, -1);
  });
  return trial_.volume();
}

// Volume of the protected region that the tool would reach on the path up to `share` [cells^3].
double SpringTool::wall_volume(const Tick& tick, double share) {
  const NoGo* const no_go = tick.mode == Mode::deposit ? nullptr : edit_.no_go();
  if (!no_go) return 0;
  const Vec3 weights = tick.weights();
  double volume = 0;
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options, int sign) {
    options.motion.along = &weights;
    walls_.reset();
    contact(no_go->model(), solid, options, walls_);
    volume += sign * walls_.volume();
  });
  return volume;
}

// Computes by what factor the wood's grain changes the resistance of the material that the last
// trial met. It does so once per tick and material: the factor varies little along the path, and
// computing it takes longer than a trial.
void SpringTool::measure_grain(const Tick& tick, double share) {
  uint64_t met = 0;
  trial_.for_parts([&](int i, const RemovedPart&) { met |= uint64_t{1} << i; });
  const uint64_t missing = met & ~tick.known;
  if (missing == 0) return;
  if (grain_) reach_volume(tick, share, grain_);
  trial_.for_parts([&](int i, const RemovedPart& part) {
    if (!((missing >> i) & 1)) return;
    const double volume = part.volume();
    tick.grained[static_cast<size_t>(i)] =
        volume > 0 ? std::max(0.0, part.resisting()) / volume : 1;
  });
  tick.known |= missing;
}

// True if the straight path up to `share` passes through thin material that resistance() misses,
// because it sums lengths of rays. This function sums volumes.
bool SpringTool::passes_thin(const Tick& tick, double share) {
  if (tick.motion.turns()) return false;
  const NoGo* const no_go = edit_.no_go();
  const auto volume = [&](double to) {
    trial_.reset();
    for_sweeps(tick, to, [&](const Solid& solid, EditOptions& options, int) {
      if (no_go)
        contact(model_, Except(solid, *no_go), options, trial_);
      else
        contact(model_, solid, options, trial_);
    });
    return trial_.volume();
  };
  const double min = kTouchVolume + kTouchArea * share * tick.length / model_.lattice().pitch_mm;
  const double there = volume(share);
  return there > min && (tick.clear || there - volume(0) > min);
}

// Weight with which the cuts over the last cell of path apply to this motion: the cosine of the
// angle between the last motion and this one, at least 0.
double SpringTool::same_direction(const Tick& tick) const {
  const double lengths =
      std::sqrt(tick.motion.travel_mm.squaredNorm() * last_displacement_mm_.squaredNorm());
  if (!(lengths > 0)) return 1;
  return std::max(0.0, tick.motion.travel_mm.dot(last_displacement_mm_) / lengths);
}

// Shape of the chip that determines the material's resistance in this tick: that of the last cell
// of path or, if nothing was cut there, that of the material that a trial reaches.
//
// Wood resists several times as hard across the fibres as along them. With a hand of limited
// strength, the solver tries paths that lead upwards or downwards. If each path had its own shape,
// the tool would dive where the resistance is low, and stick where it is high. So all paths of the
// tick use the shape of the groove that the hand draws.
const Chip& SpringTool::chip_shape(const Tick& tick, double share) {
  const bool draws = spring_.strength_n > 0 && tick.hand_mm.squaredNorm() > 0;
  const bool holds = draws ? tick.hand_mm.normalized().dot(chip_.direction) > kSameGroove
                           : same_direction(tick) > 0;
  if (chip_.section_mm2 > 0 && holds) return chip_;
  if (std::exchange(tick.shape_known, true)) return tick.shape;
  tick.shape = {};
  if (draws) {
    Tick groove = tick;
    groove.motion = {tick.motion.start, tick.hand_mm, Vec3::Zero()};
    tick.shape = shape_of_trial(groove, 1);
  }
  if (!(tick.shape.section_mm2 > 0)) tick.shape = shape_of_trial(tick, share);
  return tick.shape;
}

Chip SpringTool::shape_of_trial(const Tick& tick, double share) {
  reach_volume(tick, share, nullptr, true);
  const double h = model_.lattice().pitch_mm;
  const ToolMotion path = tick.motion.part(share);
  const Pose end = path.at(1);
  const TickMotion tried{end.tip, end.axis(), path.travel_mm, Vec3::Zero()};
  ChipMoments whole;
  trial_.for_parts([&](int, const RemovedPart& part) {
    if (part.has_chip) whole.add(resistance_of(part, tried, h).chip, 1);
  });
  // The section of this chip is not used, so the path length does not matter.
  return chip_of(whole, 1, h);
}

SpringTool::Resistance SpringTool::resistance(const Tick& tick, double share, bool ahead) {
  const double h = model_.lattice().pitch_mm, cell = h * h * h;
  const double step = share * tick.length;
  if (ahead) share = std::max(share, std::min(1.0, kWindow * h / tick.length));
  const double path = std::max(share * tick.length, kMinStep * h);
  Resistance r;
  const double all_of_it = reach_volume(tick, share);
  r.reached = std::max(0.0, all_of_it - tick.inside);
  const double volume = r.reached * cell;
  const double grazed = kTouchArea * h * h * path;
  r.room = std::max(kTouchVolume * cell + grazed - all_of_it * cell,
                    kMoreVolume * cell + grazed - volume);
  // The part of the section that lengths of rays miss.
  const double excess = tick.mode == Mode::cut ? same_direction(tick) * excess_mm2_ : 0;
  if (excess > kTouchArea * h * h) r.room = std::min(r.room, -kTouchVolume * cell);
  r.touching = r.room < 0;
  if (edit_.no_go()) {
    const double wall = wall_volume(tick, share);
    const double room =
        std::max(kTouchVolume * cell + grazed - wall * cell,
                 kMoreVolume * cell + grazed - std::max(0.0, wall - tick.wall_inside) * cell);
    r.walled = room < 0;
    r.touching |= r.walled;
    r.room = std::min(r.room, room);
  }
  if (!r.touching) return r;
  // The wall resists with a force larger than any pull.
  if (r.walled) r.force = 2 * spring_.strength_n + 2 * pull(tick.length + tick.beyond);
  if (r.walled) return r;
  measure_grain(tick, share);
  const double section = std::max(0.0, volume / path + excess);
  Chip chip;
  const bool by_law = std::any_of(tick.materials.begin(), tick.materials.end(), has_chip_law);
  if (by_law && tick.mode != Mode::deposit && section > 0)
    chip = with_section(chip_shape(tick, share), section);
  double all = 0, yield = 0, u = 0, c = 0;
  const auto add = [&](int i, double v) {
    const Material& m = material_of(tick.materials, i);
    all += v;
    yield += v * m.yield_n;
    const double grained = (tick.known >> i) & 1 ? tick.grained[static_cast<size_t>(i)] : 1;
    u += v * grained * cutting_energy(m, chip, grain_ ? &grain_->fibre() : nullptr);
    c += v * m.c;
  };
  trial_.for_parts([&](int i, const RemovedPart& part) { add(i, std::max(0.0, part.volume())); });
  if (!(all > 0)) {
    // The cut is so thin that no ray met material. So use the materials of the last cell of path.
    mean_.for_paid([&](int i, const PathMean::Resistance& paid) { add(i, paid.chip.volume); });
  }
  if (!(all > 0)) return r;
  if (tick.mode == Mode::deposit) yield = 0;
  // The viscosity counts only the volume that the step itself reaches, not that of the window
  // ahead.
  r.force =
      (spring_.hand_share * (yield + section * u) + volume / path * c * step / spring_.tick_s) /
      all;
  return r;
}

// Returns the smallest share of the path at which the spring's pull equals the resistance. The
// search starts with the displacement of the last tick. The resistance changes little from tick to
// tick, so one or two trials usually suffice.
SpringTool::Balance SpringTool::balance(const Tick& tick, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, whole_pull = pull(tick.length + tick.beyond);
  const double min = std::min(1.0, kMinStep * h / tick.length);
  const auto excess = [&](double share, const Resistance& r) {
    return r.walled || (tick.mode == Mode::touch && r.touching)
               ? -whole_pull
               : pull(tick.length * (1 - share) + tick.beyond) - r.force;
  };
  // At `low` the spring still pulls harder than the material resists; at `high` it does not. If the
  // tool does not touch at `low`, the search first finds the place of first contact, by the reached
  // volume. This volume grows steadily, but the resistance may jump there.
  Balance low{0, false};
  double high = 1, low_excess = whole_pull, high_excess = 0, low_room = kTouchVolume * h * h * h,
         high_room = 0;
  bool bracketed = false;
  if (!likely_touching) {
    const Resistance whole = resistance(tick, 1);
    high_excess = excess(1, whole);
    high_room = whole.room;
    if (!whole.touching || high_excess >= 0) return {1, whole.touching};
    bracketed = true;
  }
  double probe = std::clamp(last_step_mm_ / tick.length, min, likely_touching ? 1.0 : 0.5);
  int kept = 0;
  for (int trials = 0; trials < kMaxTrials; trials++) {
    // The resistance of a cutting tool is a mean over a distance ahead (kWindow). But only material
    // that it has reached can stop it.
    const bool ahead = touched_ && tick.mode == Mode::cut && probe * tick.length < kWindow * h;
    Resistance r = resistance(tick, probe, ahead);
    double e = excess(probe, r);
    if (ahead && e < 0)
      if (const Resistance here = resistance(tick, probe);
          !here.touching || (r.walled && !here.walled)) {
        r = here;
        e = excess(probe, r);
      }
    if (r.touching && std::abs(e) <= kBalanceShare * whole_pull) return {probe, true};
    if (e < 0) {
      high = probe;
      high_excess = e;
      high_room = r.room;
      bracketed = true;
      // Illinois method: the end that is kept twice counts half.
      if (kept < 0) low_excess *= 0.5, low_room *= 0.5;
      kept = -1;
    } else {
      if (probe >= 1) return {1, r.touching};
      low = {probe, r.touching};
      low_excess = e;
      low_room = r.room;
      if (kept > 0) high_excess *= 0.5, high_room *= 0.5;
      kept = 1;
    }
    if (bracketed &&
        high - low.share <= std::max(kBalanceError * h / tick.length, 1e-3 * low.share))
      break;
    if (high <= min) break;
    // The balance if the resistance were constant.
    const double even = 1 - r.force / (spring_.stiffness_n_mm * tick.length);
    if (!bracketed)
      probe = std::min(1.0, std::max(even, 1.01 * probe));
    else if (trials < 3 && r.touching && even > low.share && even < high)
      probe = even;
    else if (trials % 4 == 3)
      probe = 0.5 * (low.share + high);
    else if (!low.touching)
      probe = low.share + (high - low.share) * low_room / (low_room - high_room);
    else
      probe = low.share + (high - low.share) * low_excess / (low_excess - high_excess);
    probe = std::clamp(probe, min, 1.0);
  }
  if (low.share < min) return {0, true};
  return low;
}

// Pull of the hand [N] at a distance from the tool.
double SpringTool::pull(double length_mm) const {
  const double k = spring_.stiffness_n_mm, s = spring_.strength_n;
  return s > 0 ? std::min(s, k * length_mm) : k * length_mm;
}

// Length of a motion, with the turn as in spring_tool.h (L).
double SpringTool::length_of(const ToolMotion& motion) const {
  const double k = spring_.stiffness_n_mm, kt = spring_.torsion_nmm_rad;
  return std::sqrt(motion.travel_mm.squaredNorm() +
                   (k > 0 ? kt / k : 0) * motion.turn_rad.squaredNorm());
}

}  // namespace kibori
