// SPDX-License-Identifier: MIT
#include <kibori/motion/direct_tool.h>

#include <cmath>
#include <utility>

#include <kibori/motion/substeps.h>

namespace kibori {
namespace {

constexpr double kMaxTurn = 63;  // [rad] in one tick
// Rays of a row that a face reaches within so many ticks are felt as one blow, where the motion
// along them counts by this share or more and a tick is shorter than a cell.
constexpr double kBlowTicks = 2, kBlowShare = 0.01;

// Whether a flat face of the tool reaches the rays of a row, which lie along it, almost at once: in
// one tick all of them, and in the next none. `travel` in cells.
bool takes_rows(const Tool& tool, const Pose& pose, const Vec3& travel, double pitch_mm) {
  const FlatFaces faces = flat_faces(tool);
  const double length2 = travel.squaredNorm();
  if (faces.axes == 0 || !(length2 > 0 && length2 < 1)) return false;
  for (int face = 0; face < faces.axes; face++) {
    const Vec3 normal = pose.frame.col(2 - face);
    const double along = std::abs(normal.dot(travel));
    if (along * along < 1e-12 * length2) continue;  // it slides along itself
    for (int i = 0; i < 3; i++)
      if (travel[i] * travel[i] > kBlowShare * length2 &&
          (normal[i] == 0 || std::abs(normal[i]) * faces.size_mm < kBlowTicks * along * pitch_mm))
        return true;
  }
  return false;
}

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
  const SweptTool start(tool, motion.start, Vec3::Zero(), lattice);
  if (substeps > 1) {
    // A cut that is taken back: what one substep reaches, the next must not count again.
    const Snapshot before = model_.snapshot();
    Removed inside;
    cut(model_, start, options, inside);
    ToolEdit(model_).run(tool, motion, motion.at(1), substeps, false, 0, options.threads, removed_);
    model_.restore(before);
    return;
  }
  const SweptTool sweep(tool, motion.substep(0, 1), motion.travel_mm, lattice);
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
  const SweptTool there(tool, motion.start, Vec3::Zero(), lattice);
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
  const ToolMotion motion{pose_, tip_mm - pose_.tip, turn_rad};
  const bool turning = motion.turns();
  const Vec3& travel = motion.travel_mm;
  ToolTick result = moved_tick(motion, tip_mm);
  const Pose& end = result.pose;
  removed_.reset();
  edit_.set_passing(law.model != ForceModel::paper && mode != Mode::deposit && !turning &&
                    takes_rows(tool, pose_, travel / lattice.pitch_mm, lattice.pitch_mm));
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
  pose_ = end;
  return result;
}

}  // namespace kibori
