// SPDX-License-Identifier: MIT
#include <kibori/reshape/clay.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/memory.h>
#include <kibori/edit/edit.h>
#include <kibori/reshape/write_back.h>

namespace kibori {
namespace {

// Nodes whose distance is known [cells]: those that may change sides, and their neighbours' slopes.
constexpr double kWidth = Clay::kMaxRise + 2;
// Of secant steps: it converges in two or three.
constexpr int kMaxSteps = 8;
// Relative to the volume wanted.
constexpr double kTolerance = 1e-5;
// What bands and weights keep of a node, and beyond how many nodes there is no region.
constexpr double kBytesPerNode = 40, kMaxNodes = 2147483648.0, kSurelyThere = 256e6;

}  // namespace

// Signed distances to the tools, at the nodes of `box`, into tool_band_: there the box begins at 0.
void Clay::measure_tool(const Tool& tool, std::span<const Pose> tools, const Lattice& lattice,
                        const NodeBox& box) {
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
  for (const Pose& pose : tools) {
    const SweptTool solid(tool, {pose.tip - corner, pose.frame}, Vec3::Zero(), scratch_->lattice(),
                          scratch_->lattice().whole());
    Removed added;
    deposit(*scratch_, solid.solid(), 0, {}, added);
  }
  // What is cut off by the box's border is no surface of the tool.
  tool_band_.read(*scratch_, {Index3::Zero(), box.size()}, static_cast<float>(kRamp + 1));
}

Result<Reshaped> Clay::raise(TriDexel& model, const Tool& tool, std::span<const Pose> tools,
                             const Vec3& centre_mm, double radius_mm, double volume_mm3) {
  if (!centre_mm.allFinite() || !(radius_mm > 0) || !std::isfinite(radius_mm) ||
      !std::isfinite(volume_mm3))
    return Error{"a collar of clay needs a finite place, a radius above 0 and a finite volume"};
  const Lattice& lattice = model.lattice();
  const double pitch = lattice.pitch_mm, radius = radius_mm / pitch;
  const double wanted = volume_mm3 / (pitch * pitch * pitch);
  const Vec3 centre = lattice.to_lattice(centre_mm).units;
  for (int i = 0; i < 3; i++)
    if (!(centre[i] + radius > 0 && centre[i] - radius < lattice.nodes[i])) return Reshaped{};
  if (!(wanted > 0)) return Reshaped{};

  // As large whatever the place, so that the scratch model is used again; beyond the lattice all is
  // outside.
  const int reach = static_cast<int>(std::ceil(radius + kWidth)) + 2;
  NodeBox box;
  for (int i = 0; i < 3; i++) {
    box.low[i] = static_cast<int>(std::floor(centre[i])) - reach;
    box.high[i] = box.low[i] + 2 * reach + 1;
  }
  const double nodes = box.size().cast<double>().prod(), bytes = kBytesPerNode * nodes;
  const double there = bytes > kSurelyThere ? available_bytes() : 0;
  if (nodes >= kMaxNodes || (there > 0 && bytes > 0.8 * there) ||
      (box.size() > kMaxNodesPerAxis).any())
    return Error{"the tool is too large for this pitch: its collar of clay takes too much memory"};
  band_.read(model, box, static_cast<float>(kWidth), LatticePoint{centre},
             static_cast<float>(radius + 2));
  if (band_.nodes().empty()) return Reshaped{};
  measure_tool(tool, tools, lattice, box);

  const std::vector<float>& phi = band_.phi();
  after_ = phi;
  touched_.clear();
  weights_.clear();
  double area = 0;
  for (const uint32_t node : band_.nodes()) {
    const Index3 at = band_.node_at(node);
    if ((at < 0).any() || (at >= lattice.nodes).any()) continue;
    const Vec3 from = at.matrix().cast<double>().array() + 0.5 - centre.array();
    const double off = double{tool_band_.phi()[node]} / kRamp;
    const double weight =
        falloff_weight(Falloff::smooth, from.norm() / radius) * std::clamp(off, 0.0, 1.0);
    if (!(weight > 0)) continue;
    touched_.push_back(node);
    weights_.push_back(static_cast<float>(weight));
    if (std::fabs(phi[node]) < 0.5) area += weight;
  }
  if (!(area > 0)) return Reshaped{};
  const auto with = [&](double lambda) {
    for (size_t i = 0; i < touched_.size(); i++) {
      const uint32_t node = touched_[i];
      if (std::fabs(phi[node]) < kWidth - 1)
        after_[node] = phi[node] - static_cast<float>(lambda) * weights_[i];
    }
    return volume_change(model, band_, after_, touched_);
  };
  // Secants, between nothing and the most that one collar rises.
  double last = 0, last_volume = 0, lambda = std::min(wanted / area, kMaxRise);
  for (int step = 0; step < kMaxSteps; step++) {
    const double volume = with(lambda);
    if (std::fabs(volume - wanted) <= kTolerance * wanted || volume == last_volume) break;
    const double next = lambda + (wanted - volume) * (lambda - last) / (volume - last_volume);
    last = lambda;
    last_volume = volume;
    lambda = std::clamp(next, 0.0, kMaxRise);
    if (lambda == last) break;
  }
  return write_back(model, band_, after_, touched_);
}

}  // namespace kibori
