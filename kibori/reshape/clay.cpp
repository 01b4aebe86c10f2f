// SPDX-License-Identifier: MIT
#include <kibori/reshape/clay.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>

#include <kibori/base/memory.h>
#include <kibori/base/parallel.h>
#include <kibori/edit/edit.h>
#include <kibori/reshape/band_kernels.h>
#include <kibori/reshape/write_back.h>

namespace kibori {
namespace {

// How far from the surface nodes are computed for collars up to the height `rise` [cells].
// Distances are read up to `width`. Only nodes with |phi| < `core` are changed.
struct Depth {
  float core, width;
  double rise;
};
constexpr std::array<Depth, 3> kDepths{{{2.5f, 2.5f, 1},
                                        {3.75f, 3.75f, 2.25},
                                        {static_cast<float>(Clay::kMaxRise + 1),
                                         static_cast<float>(Clay::kMaxRise + 2), Clay::kMaxRise}}};
constexpr const Depth& kWhole = kDepths.back();
// Area of a collar's surface, weighted by the falloff, as a share of the same for a plane. The tool
// covers the rest. The benchmark measured 0.3 to 0.6. The value only selects the Depth that is
// tried first.
constexpr double kShareOfPlane = 0.4;
// Steps of the search for a height. Secants converge in one or two steps. After kSecants steps,
// bisection follows. From the second height that is too low on, steps are longer by the factor
// kBeyond, so that an upper bound is found too.
constexpr int kMaxSteps = 24, kSecants = 8;
constexpr double kBeyond = 1.05;
// Nodes that do not rise are also read within this distance of those that rise [nodes].
constexpr uint32_t kMargin = 2;
// If the tolerance is at least this, nodes give the volume (WriteBack::rough_volume), not spans.
constexpr double kRoughTolerance = 5e-3;
// Maximum number of nodes of a region. Memory below kUncheckedClayBytes [bytes] is used without a
// check.
constexpr double kMaxClayNodes = 2147483648.0, kUncheckedClayBytes = 256e6;

}  // namespace

Clay::Clay() : writer_(std::make_unique<WriteBack>()) {}
Clay::~Clay() = default;

// Computes signed distances to the tools' paths at the touched nodes of `box`, into path_band_. In
// path_band_, the box begins at 0.
void Clay::measure_path(const Tool& tool, std::span<const PressingTool> tools, double radius_mm,
                        const Lattice& lattice, const NodeBox& box) {
  if (!scratch_ || (scratch_->lattice().nodes != box.size()).any() ||
      scratch_->lattice().pitch_mm != lattice.pitch_mm) {
    Lattice around;
    around.nodes = box.size();
    around.pitch_mm = lattice.pitch_mm;
    scratch_ = std::make_unique<TriDexel>(around);
    empty_ = scratch_->snapshot();
  }
  scratch_->restore(empty_);
  const Vec3 corner = lattice.to_mm(LatticePoint{box.low.matrix().cast<double>()});
  std::deque<SweptTool> sweeps;  // a deque, so that elements do not move
  const auto add = [&](const Pose& from, const Vec3& displacement) {
    sweeps.emplace_back(tool, Pose{from.tip - corner, from.frame}, displacement,
                        scratch_->lattice());
  };
  for (const PressingTool& at : tools) {
    const Vec3 along = radius_mm * at.direction, out = radius_mm * at.pose.axis();
    const Pose front{at.pose.tip + along, at.pose.frame}, back{at.pose.tip - along, at.pose.frame};
    add(back, 2 * along);
    for (const Pose* pose : {&front, &at.pose, &back}) add(*pose, out);
  }
  run_parallel(threads_, 3, [&](size_t axis) {
    Removed added;
    for (const SweptTool& sweep : sweeps)
      deposit_field(scratch_->field(kAxes[axis]), sweep.solid(), 0, added);
  });
  // A path that the box cuts off has no surface at the cut.
  path_band_.read_at(*scratch_, {Index3::Zero(), box.size()}, static_cast<float>(kRamp), touched_,
                     band_.turn());
}

Result<Reshaped> Clay::raise(TriDexel& model, const Tool& tool, std::span<const PressingTool> tools,
                             size_t of, double radius_mm, double volume_mm3, double tolerance) {
  const Vec3& centre_mm = tools[of].middle_mm;
  if (!centre_mm.allFinite() || !(radius_mm > 0) || !std::isfinite(radius_mm) ||
      !std::isfinite(volume_mm3))
    return Error{"a collar of clay needs a finite place, a radius above 0 and a finite volume"};
  const Lattice& lattice = model.lattice();
  const double pitch = lattice.pitch_mm, radius = radius_mm / pitch;
  const double wanted = volume_mm3 / (pitch * pitch * pitch);
  const Vec3 centre = lattice.to_lattice(centre_mm).units;
  for (int i = 0; i < 3; i++)
    if (!(centre[i] + radius > lattice.low()[i] && centre[i] - radius < lattice.high()[i]))
      return Reshaped{};
  if (wanted == 0) return Reshaped{};

  // The size does not depend on the place, so that the scratch model can be reused. Everything
  // beyond the lattice is outside.
  const int reach = static_cast<int>(std::ceil(radius + double{kWhole.width})) + 2;
  NodeBox box;
  for (int i = 0; i < 3; i++) {
    box.low[i] = static_cast<int>(std::floor(centre[i])) - reach;
    box.high[i] = box.low[i] + 2 * reach + 1;
  }
  const double nodes = box.size().cast<double>().prod(),
               bytes = static_cast<double>(kBytesPerNode) * nodes;
  const double there = bytes > kUncheckedClayBytes ? available_bytes() : 0;
  if (nodes >= kMaxClayNodes || (there > 0 && bytes > 0.8 * there) ||
      (box.size() > kMaxNodesPerAxis).any())
    return Error{"the tool is too large for this pitch: its collar of clay takes too much memory"};
  // Most collars are low. A collar that is higher than expected is computed again.
  const double plane = std::numbers::pi / 3 * radius * radius,
               expected = std::fabs(wanted) / (kShareOfPlane * plane);
  const Depth* depth = kDepths.data();
  while (depth != &kWhole && expected > depth->rise) depth++;
  const AxisTurn turn = turn_along_surface(model, LatticePoint{centre}, radius);
  const LatticePoint turned{turn.turn(centre)};
  while (true) {
    band_.read(
        model, box.turned(turn), depth->width, turn,
        {.centre = turned, .reach = static_cast<float>(radius + kMargin), .margin = kMargin});
    if (!find_touched(lattice_nodes(lattice).turned(turn), turned, radius, depth->core))
      return Reshaped{};
    measure_path(tool, tools, radius_mm, lattice, box);
    const double area = weigh(turned, radius);
    band_.copy_computed_phi(after_);
    writer_->begin(band_, touched_, threads_);
    const bool found = !(area > 0) || rise(model, wanted, area, depth->rise, tolerance);
    if (depth == &kWhole ||
        (found && !changes_beyond(band_, after_, touched_, depth->core, kWhole.core, threads_)))
      break;
    depth++;
  }
  return writer_->write(model, after_);
}

// Finds the nodes within the lattice with |phi| < core, in blocks that the collar's radius reaches.
// Returns true if there are some.
bool Clay::find_touched(const NodeBox& all, const LatticePoint& centre, double radius, float core) {
  band_.blocks_within(core, touched_, [&](NodeBlock& block) {
    Vec3 off = Vec3(block.i, block.j, block.k).array() + 0.5 - centre.units.array();
    off[0] = std::max({0.0, off[0], -(off[0] + 15)});
    const bool near = off.squaredNorm() < radius * radius && block.j >= all.low[1] &&
                      block.j < all.high[1] && block.k >= all.low[2] && block.k < all.high[2];
    block.nodes =
        near ? static_cast<uint16_t>(block.nodes_along(all.low[0], all.high[0])) : uint16_t{0};
  });
  return !touched_.empty();
}

// Computes the collar's weights, and reduces the touched nodes to those that rise. Returns the
// integral of the weights over the surface.
double Clay::weigh(const LatticePoint& centre, double radius) {
  weights_.resize(touched_.size());
  areas_.resize(touched_.size());
  const auto weigh = band_kernels().weigh_collar;
  run_parallel_ranges(threads_, touched_.size(), [&](size_t first, size_t number) {
    weigh({touched_.data() + first, number, band_.phi().data(), path_band_.phi().data(),
           centre.units, radius, kRamp, weights_.data() + first, areas_.data() + first});
  });
  size_t count = 0;
  double area = 0;
  for (size_t b = 0; b < touched_.size(); b++) {
    if (!touched_[b].nodes) continue;
    touched_[count] = touched_[b];
    weights_[count] = weights_[b];
    area += areas_[b];
    count++;
  }
  touched_.resize(count);
  return area;
}

// Computes phi after the collar rose by the height that adds the wanted volume [lattice units^3],
// or by kMaxRise. Returns false if it must rise by more than `max_rise`.
bool Clay::rise(const TriDexel& model, double wanted, double area, double max_rise,
                double tolerance) {
  const double sign = wanted > 0 ? 1 : -1, size = std::fabs(wanted);
  const auto raise_by = [&](double lambda) {
    const auto by = static_cast<float>(lambda);
    run_parallel_pieces(threads_, touched_.size(), [&](size_t b) {
      const NodeBlock& block = touched_[b];
      const float *phi = band_.phi().data() + block.place, *weight = weights_[b].lane;
      float* after = after_.data() + block.place;
      // The other nodes of the block have weight 0.
      for (int n = 0; n < 16; n++) after[n] = phi[n] - by * weight[n];
    });
  };
  // The volume grows with lambda. It has kinks and steps where a surface along the lattice passes
  // nodes. Therefore, the root is kept between two bounds. Secants come first, then bisection.
  double low = 0, low_volume = 0, high = kMaxRise, high_volume = 0;
  bool known = false;  // true if high_volume is known
  double lambda = std::min(size / area, kMaxRise);
  for (int step = 0; step < kMaxSteps; step++) {
    if (lambda > max_rise) return false;
    raise_by(sign * lambda);
    const double volume =
                     sign * (tolerance < kRoughTolerance ? writer_->volume(model, after_)
                                                         : writer_->rough_volume(model, after_)),
                 off = volume / size - 1;
    if (std::fabs(off) <= tolerance) return true;
    double from = low, from_volume = low_volume, beyond = 1;  // the secant's other end
    if (volume < size) {
      if (lambda == kMaxRise) return true;
      if (known) {
        from = high;
        from_volume = high_volume;
      } else if (step > 0) {
        beyond = kBeyond;
      }
      low = lambda;
      low_volume = volume;
    } else {
      high = lambda;
      high_volume = volume;
      known = true;
    }
    const double slope = (volume - from_volume) / (lambda - from),
                 ahead = slope > 0 ? (size - volume) / slope : kMaxRise;
    const double secant = std::min(lambda + beyond * ahead, kMaxRise);
    lambda = known && (step >= kSecants || !(secant > low && secant < high)) ? 0.5 * (low + high)
                                                                             : secant;
  }
  // The wanted volume is inside a step. Takes the nearer side of the step, but not a side that
  // changes nothing.
  const bool nearer = known && (low == 0 || high_volume - size < size - low_volume);
  raise_by(sign * (nearer ? high : low));
  return true;
}

}  // namespace kibori
