// SPDX-License-Identifier: MIT
#include <kibori/motion/direct_tool.h>

#include <cmath>
#include <utility>

#include <kibori/motion/substeps.h>

namespace kibori {
namespace {

constexpr double kMaxTurn = 63;  // [rad] in one tick
constexpr double kLongTick = 1;  // [cells]

// What a tool stands in is no way of its surface: where that is summed, nothing that resists is
// taken away again.
EditOptions standing_still(EditOptions options) {
  if (std::exchange(options.motion.passing, false) && !options.motion.turning)
    options.motion.grain = nullptr;
  return options;
}

}  // namespace

void DirectTool::touch(const Tool& tool, const ToolMotion& motion, int substeps,
                       const EditOptions& options) {
  const Lattice& lattice = model_.lattice();
  const SweptTool start(tool, motion.start, Vec3::Zero(), lattice, model_.material_bounds());
  if (substeps > 1) {
    // A cut that is taken back: what one substep reaches, the next must not count again.
    const Snapshot before = model_.snapshot();
    Removed inside;
    cut(model_, start, options, inside);
    ToolEdit(model_).run(tool, motion, motion.at(1), substeps, false, 0, options.threads, removed_);
    model_.restore(before);
    return;
  }
  const SweptTool sweep(tool, motion.substep(0, 1), motion.travel_mm, lattice,
                        model_.material_bounds());
  if (!is_convex(tool)) {
    // The start pose is part of the sweep: its share is taken away again.
    Removed before;
    contact(model_, start, standing_still(options), before);
    contact(model_, sweep, options, removed_);
    removed_.add(before, -1);
    return;
  }
  contact(model_, Difference(sweep, start), options, removed_);
}

void DirectTool::stand(const Tool& tool, const ToolMotion& motion, const Pose& end, bool deposits,
                       uint8_t material) {
  const Lattice& lattice = model_.lattice();
  const EditOptions options =
      standing_still({sums_of(motion, end, lattice, edit_.grain(), edit_.passing()), threads_});
  const SweptTool there(tool, motion.start, Vec3::Zero(), lattice,
                        deposits ? lattice.whole() : model_.material_bounds());
  standing_.reset();
  if (deposits)
    deposit_contact(model_, there.solid(), material, options, standing_);
  else
    contact(model_, there.solid(), options, standing_);
}

Result<ToolTick> DirectTool::advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad,
                                     Mode mode, const ForceLaw& law,
                                     const std::vector<Material>& materials, uint8_t material) {
  const Lattice& lattice = model_.lattice();
  if (!tip_mm.allFinite() || !(turn_rad.squaredNorm() <= kMaxTurn * kMaxTurn))
    return Error{
        "one tick moves the tool to no place at all, or turns it more than ten times around"};
  if (reshapes(mode)) mode = Mode::off;
  ToolTick result;
  const ToolMotion motion{pose_, tip_mm - pose_.tip, turn_rad};
  const bool turning = motion.turns();
  const Vec3& travel = motion.travel_mm;
  Pose end = motion.at(1);
  end.tip = tip_mm;
  result.motion = {end.tip, end.axis(), travel, turning ? turn_rad : Vec3(Vec3::Zero())};
  removed_.reset();
  // Where a tick is long, no row of rays stands out, and lengths are exact.
  edit_.set_passing(law.model != ForceModel::paper && mode != Mode::deposit &&
                    has_flat_faces(tool) && motion.travel_mm.norm() < kLongTick * lattice.pitch_mm);
  if (mode != Mode::off) {
    const Result<int> counted = substeps_of(tool, motion, lattice);
    if (!counted) return Error{counted.error()};
    const int substeps = counted.value();
    const bool stood = mode != Mode::touch && law.model != ForceModel::paper &&
                       !law.start_resists && std::exchange(begins_, false);
    if (mode == Mode::touch) {
      touch(tool, motion, substeps,
            {sums_of(motion, end, lattice, edit_.grain(), edit_.passing()), threads_});
    } else {
      if (stood) stand(tool, motion, end, mode == Mode::deposit, material);
      edit_.run(tool, motion, end, substeps, mode == Mode::deposit, material, threads_, removed_);
    }
    const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
    const double sign = mode == Mode::deposit ? -1 : 1;
    if (stood) removed_.add(standing_, -1);
    result.wrench =
        wrench(law, removed_, result.motion, lattice.pitch_mm, lattice.origin_mm, materials);
    if (stood) removed_.add(standing_);
    result.points = removed_.points();
    if (mode != Mode::touch) removed_.add(edit_.images());
    result.removed_mm3 = sign * removed_.mean_volume() * cell;
    result.clipped = removed_.clipped;
    result.edited = mode != Mode::touch;
  }
  result.pose = pose_ = end;
  return result;
}

}  // namespace kibori
