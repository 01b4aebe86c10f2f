// SPDX-License-Identifier: MIT
#include <kibori/motion/spring_tick.h>

#include <kibori/edit/edit.h>

namespace kibori {

using namespace spring;

namespace {

// The balance is solved to this share of the pull, or to this way [cells], or to a thousandth of
// the way.
constexpr double kBalanceShare = 3e-4;
constexpr double kBalanceError = 1e-4;
// What is only tried turns in so many times fewer pieces than what is cut: its outermost point may
// stray by four tenths of a cell. Fewer, and walls are felt where they are not; more, and a turning
// tool costs a tick ten times what a straight one does.
constexpr int kTrialPieces = 4;

}  // namespace

// Calls f(solid, edit's options) for the straight substeps of the way up to `share`.
template <class F>
void SpringTool::for_sweeps(const Tick& tick, double share, F&& f) const {
  const Lattice& lattice = model_.lattice();
  const ToolMotion way = tick.motion.part(share);
  const Result<int> counted = substeps_of(tick.tool, way, lattice);
  // advance() has refused what has too many.
  const int substeps = counted ? (counted.value() + kTrialPieces - 1) / kTrialPieces : 1;
  EditOptions options;
  options.motion = {lattice.to_lattice(way.at(1).tip), false, LatticeVector(), Vec3::Zero(),
                    way.start.axis()};
  for (int i = 0; i < substeps; i++) {
    const SweptTool sweep(tick.tool, way.substep(i, substeps), way.travel_mm / substeps, lattice,
                          tick.clear && substeps == 1);
    f(sweep.solid(), options);
  }
}

double SpringTool::reach_volume(const Tick& tick, double share, const Grain* grain) {
  trial_.reset();
  const Vec3 weights = tick.weights();
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options) {
    for (size_t i = 0; i < 3; i++) options.fields[i] = weights[static_cast<int>(i)] > 0;
    options.motion.grain = grain;
    if (grain) options.motion.across2 = grain->across2(tick.motion.travel_mm);
    if (tick.mode == Mode::deposit)
      deposit_contact(model_, solid, tick.material, options, trial_);
    else
      contact(model_, solid, options, trial_);
  });
  double sum = 0;
  trial_.for_parts([&](int, const RemovedPart& part) { sum += tick.volume(part); });
  return sum;
}

// The same [cells^3] of what is not cut.
double SpringTool::wall_volume(const Tick& tick, double share) {
  const NoGo* const no_go = tick.mode == Mode::deposit ? nullptr : edit_.no_go();
  if (!no_go) return 0;
  walls_.reset();
  const Vec3 weights = tick.weights();
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options) {
    for (size_t i = 0; i < 3; i++) options.fields[i] = weights[static_cast<int>(i)] > 0;
    contact(no_go->model(), solid, options, walls_);
  });
  double sum = 0;
  walls_.for_parts([&](int, const RemovedPart& part) { sum += tick.volume(part); });
  return sum;
}

// What the wood's grain makes of what the last trial met: asked once in a tick of each material, as
// it changes little along a tick's way and takes longer than the trial itself.
void SpringTool::feel_grain(const Tick& tick, double share) {
  uint64_t met = 0;
  trial_.for_parts([&](int i, const RemovedPart&) { met |= uint64_t{1} << i; });
  const uint64_t missing = met & ~tick.known;
  if (missing == 0) return;
  if (grain_) reach_volume(tick, share, grain_);
  trial_.for_parts([&](int i, const RemovedPart& part) {
    if (!((missing >> i) & 1)) return;
    const double volume = tick.volume(part);
    tick.grained[static_cast<size_t>(i)] = volume > 0 ? tick.resisting(part) / volume : 1;
  });
  tick.known |= missing;
}

SpringTool::Resistance SpringTool::resistance(const Tick& tick, double share, bool ahead) {
  const double h = model_.lattice().pitch_mm, cell = h * h * h;
  const double step = share * tick.length;
  if (ahead) share = std::max(share, std::min(1.0, kWindow * h / tick.length));
  const double way = std::max(share * tick.length, kMinStep * h);
  Resistance r;
  const double all_of_it = reach_volume(tick, share);
  r.reached = std::max(0.0, all_of_it - tick.inside);
  const double volume = r.reached * cell;
  const double grazed = kTouchArea * h * h * way;
  r.room = std::max(kTouchVolume * cell + grazed - all_of_it * cell,
                    kMoreVolume * cell + grazed - volume);
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
  // More than any hand pulls with.
  if (r.walled) r.force = 2 * spring_.strength_n + 2 * pull(tick.length + tick.beyond);
  if (r.walled) return r;
  feel_grain(tick, share);
  double all = 0, yield = 0, u = 0, c = 0;
  trial_.for_parts([&](int i, const RemovedPart& part) {
    const double v = std::max(0.0, tick.volume(part));
    const Material& m = material_of(tick.materials, i);
    all += v;
    yield += v * spring_.hand_share * m.yield_n;
    u += v * tick.grained[static_cast<size_t>(i)] * spring_.hand_share * m.u;
    c += v * m.c;
  });
  if (!(all > 0)) return r;
  if (tick.mode == Mode::deposit) yield = 0;
  // Viscosity goes by what the step itself would reach in the tick.
  r.force = (yield + volume / way * (u + c * step / spring_.tick_s)) / all;
  return r;
}

// The share of the way at which the spring's pull equals what resists: the first such place from
// where the last tick ended. Resistance seldom changes much from tick to tick, so one or two trials
// are the rule.
SpringTool::Balance SpringTool::balance(const Tick& tick, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, whole_pull = pull(tick.length + tick.beyond);
  const double min = std::min(1.0, kMinStep * h / tick.length);
  const auto excess = [&](double share, const Resistance& r) {
    return r.walled || (tick.mode == Mode::touch && r.touching)
               ? -whole_pull
               : pull(tick.length * (1 - share) + tick.beyond) - r.force;
  };
  // At `low` the spring still pulls harder than the material resists; at `high` it does not. Where
  // it does not touch yet at `low`, the place where it begins to is looked for first: the pull may
  // jump there, but what is reached grows steadily.
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
    // A tool that cuts looks a little ahead (kWindow); but what it does not reach yet can't stop
    // it.
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
      // Illinois: the end that is kept twice counts half.
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
    // Were the resistance the same elsewhere, the balance would be here.
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

// At a distance from the tool.
double SpringTool::pull(double length_mm) const {
  const double k = spring_.stiffness_n_mm, s = spring_.strength_n;
  return s > 0 ? std::min(s, k * length_mm) : k * length_mm;
}

// The way, the turn included as the spring's energy weighs it.
double SpringTool::length_of(const ToolMotion& motion) const {
  const double k = spring_.stiffness_n_mm, kt = spring_.torsion_nmm_rad;
  return std::sqrt(motion.travel_mm.squaredNorm() +
                   (k > 0 ? kt / k : 0) * motion.turn_rad.squaredNorm());
}

}  // namespace kibori
