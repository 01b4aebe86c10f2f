// SPDX-License-Identifier: MIT
#include <kibori/motion/direct_tool.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <kibori/motion/substeps.h>

namespace kibori {
namespace {

constexpr double kMaxTurn = 63;  // [rad] in one tick

bool needs_chip(const ForceLaw& law, const std::vector<Material>& materials) {
  if (law.model == ForceModel::paper) return false;
  return law.thrust > 0 || std::any_of(materials.begin(), materials.end(), has_chip_law);
}

}  // namespace

void DirectTool::touch(const Tool& tool, const ToolMotion& motion, int substeps,
                       const EditOptions& options) {
  const Lattice& lattice = model_.lattice();
  const SweptTool start(tool, motion.start, Vec3::Zero(), lattice);
  if (substeps > 1) {
    // A substep must not count material that an earlier substep reached. So the substeps cut the
    // model, and restore() undoes the cuts.
    const Snapshot before = model_.snapshot();
    Removed inside;
    cut(model_, start, options, inside);
    ToolEdit(model_).run(tool, motion, motion.at(1), substeps, false, 0, options.threads, removed_);
    model_.restore(before);
    return;
  }
  const SweptTool sweep(tool, motion.substep(0, 1), motion.travel_mm, lattice);
  // The sweep includes the tool at its start pose. Material there does not count, so subtract it.
  Removed before;
  contact(model_, start, options, before);
  contact(model_, sweep, options, removed_);
  removed_.add(before, -1);
}

void DirectTool::measure_start(const Tool& tool, const ToolMotion& motion, const Pose& end,
                               bool deposits, uint8_t material) {
  const Lattice& lattice = model_.lattice();
  const EditOptions options{sums_of(motion, end, lattice, edit_.grain(), edit_.chip()), threads_};
  const SweptTool there(tool, motion.start, Vec3::Zero(), lattice);
  standing_.reset();
  if (deposits)
    deposit_contact(model_, there.solid(), material, options, standing_);
  else
    contact(model_, there.solid(), options, standing_);
}

Wrench DirectTool::wrench(const Tool& tool, const ForceLaw& law, const TickMotion& tick,
                          const std::vector<Material>& materials) {
  const Lattice& lattice = model_.lattice();
  const double h = lattice.pitch_mm;
  Wrench sum;
  const auto add = [&](const Wrench& one) {
    sum.force += one.force;
    sum.moment += one.moment;
  };
  if (law.model == ForceModel::paper) {
    removed_.for_parts([&](int i, const RemovedPart& part) {
      add(paper_wrench(law.dof, part, material_of(materials, i), tick, h, lattice.origin_mm));
    });
    return sum;
  }
  const double cells = path_cells(tool, tick, h);
  if (!(cells > 0)) return sum;
  if (tick.travel.dot(last_travel_mm_) < 0) mean_.drop();  // the motion reverses
  last_travel_mm_ = tick.travel;
  if (edit_.chip()) mean_.put_cells(removed_.cells(), cells);
  removed_.for_parts(
      [&](int i, const RemovedPart& part) { mean_.put(i, resistance_of(part, tick, h), cells); });
  mean_.pay(cells);
  ChipMoments whole;
  mean_.for_paid([&](int, const PathMean::Resistance& paid) { whole.add(paid.chip, 1); });
  if (edit_.chip()) chip_ = chip_of(whole, cells, h, mean_.gaps());
  const Grain* const grain = edit_.grain();
  mean_.for_paid([&](int i, const PathMean::Resistance& paid) {
    const double u =
        cutting_energy(material_of(materials, i), chip_, grain ? &grain->fibre() : nullptr);
    add(energy_wrench(law, paid, u, tick, h));
  });
  if (law.thrust > 0) add(thrust_wrench(law, whole, chip_, sum.force, tick, h));
  return sum;
}

Result<ToolTick> DirectTool::advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad,
                                     Mode mode, const ForceLaw& law,
                                     const std::vector<Material>& materials, uint8_t material) {
  const Lattice& lattice = model_.lattice();
  if (!tip_mm.allFinite() || !(turn_rad.squaredNorm() <= kMaxTurn * kMaxTurn))
    return Error{
        "one tick moves the tool to a position that is not finite, or turns it by more than ten "
        "full turns"};
  if (reshapes(mode)) mode = Mode::off;
  const ToolMotion motion{pose_, tip_mm - pose_.tip, turn_rad};
  ToolTick result = moved_tick(motion, tip_mm);
  const Pose& end = result.pose;
  removed_.reset();
  chip_ = {};
  edit_.set_chip(needs_chip(law, materials));
  if (mode == Mode::off) mean_.drop();
  if (mode != Mode::off) {
    const Result<int> counted = substeps_of(tool, motion, lattice);
    if (!counted) return Error{counted.error()};
    const int substeps = counted.value();
    const bool measured = mode != Mode::touch && law.model != ForceModel::paper &&
                          !law.start_resists && std::exchange(begins_, false);
    if (mode == Mode::touch) {
      touch(tool, motion, substeps,
            {sums_of(motion, end, lattice, edit_.grain(), edit_.chip()), threads_});
    } else {
      if (mode == Mode::deposit) edit_.make_room(tool, motion, substeps);
      if (measured) measure_start(tool, motion, end, mode == Mode::deposit, material);
      edit_.run(tool, motion, end, substeps, mode == Mode::deposit, material, threads_, removed_);
    }
    const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
    const double sign = mode == Mode::deposit ? -1 : 1;
    if (measured) removed_.add(standing_, -1);
    result.wrench = wrench(tool, law, result.motion, materials);
    if (measured) removed_.add(standing_);
    result.points = removed_.points();
    if (mode != Mode::touch) removed_.add(edit_.images());
    result.removed_mm3 = sign * removed_.volume() * cell;
    result.clipped = removed_.clipped;
    result.edited = mode != Mode::touch;
  }
  pose_ = end;
  return result;
}

}  // namespace kibori
