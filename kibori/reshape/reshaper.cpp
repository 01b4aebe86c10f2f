// SPDX-License-Identifier: MIT
#include <kibori/reshape/reshaper.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <kibori/base/memory.h>
#include <kibori/base/parallel.h>
#include <kibori/reshape/band_kernels.h>
#include <kibori/reshape/write_back.h>

namespace kibori {
namespace {

// kSlopeReach: cells from a changing node to the nodes whose slopes give its new ends' normals.
// kReachSlack: the float32 error of a position.
constexpr float kSlopeReach = 2;
constexpr double kReachSlack = 0.01;

// The filter reaches this many sigma; 1.2 % of the weight is beyond. At three, 0.3 % is beyond, and
// a dab takes a seventh longer.
constexpr double kFilterReach = 2.5;

// A filter's band is wider than the filter's reach by this [sigma, and cells]. Otherwise, nodes
// near the surface would use clamped distances, and the filter would move a plane.
constexpr double kBandSigmas = 0.5, kBandCells = 2;

// Bisections for a filter's width: to 1e-6 of a cell.
constexpr int kWidthSteps = 24;

// A filter with a smaller sigma [cells] has one node.
constexpr double kMinSigma = 0.05;

// Minimum width of a band [cells]. It covers the nodes of an end's edge and those whose slopes give
// its normal.
constexpr double kMinWidth = 4;

// Nodes up to this depth [sigma, and cells] may change sides in one dab. The deepest cases: the
// middle of a slab that vanishes is 0.8 sigma deep, and a cube's corner moves by 1.5 sigma.
constexpr double kCoreSigmas = 1.6, kCoreCells = 1.5;
// Nodes up to this depth [cells] are computed first. They are enough for a surface that moves by
// half a cell. The others are computed only if it moves farther.
constexpr float kNearCore = 2.5f;
constexpr double kNearRise = 0.5;

// Maximum number of secant steps to keep the volume. The steps converge in two or three.
constexpr int kMaxVolumeSteps = 8;
// Permitted error of the volume, as a share of the moved volume.
constexpr double kVolumeTolerance = 1e-4;
// Maximum rise of the surface per dab [cells] to restore the pending volume of earlier dabs.
constexpr double kPendingRise = 0.02;

// Material is reported as dropped if the surface would be half of this [cells] beyond the lattice.
// Smaller amounts are rounding error, or noise of faces on the border.
constexpr float kMinClipped = 0.1f;

constexpr double kMaxRegionNodes = 2147483648.0;
// A dab does not check for memory below this amount.
constexpr double kUncheckedBytes = 256e6;

// exp(-x), x >= 0, from sums and products only, so it is the same on every machine.
double exp_minus(double x) {
  double halved = x;
  int halvings = 0;
  for (; halved > 0.25; halved *= 0.5) halvings++;
  double sum = 1;
  for (int n = 14; n >= 1; n--) sum = 1 - halved / n * sum;
  for (; halvings > 0; halvings--) sum *= sum;
  return sum;
}

// The weights of a Gaussian at 0, 1, ... cells. The sum of both sides is 1. The variance of the
// weights is sigma^2, in spite of sampling and cut-off.
void gaussian(double sigma, std::vector<float>& kernel) {
  const int reach = sigma < kMinSigma ? 0 : static_cast<int>(std::ceil(kFilterReach * sigma));
  kernel.assign(static_cast<size_t>(reach) + 1, 1);
  if (reach == 0) return;
  const auto sums = [&](double width) {
    double sum = 1, variance = 0;
    for (int i = 1; i <= reach; i++) {
      const double weight = exp_minus(0.5 * i * i / (width * width));
      sum += 2 * weight;
      variance += 2 * i * i * weight;
    }
    return std::pair{sum, variance / sum};
  };
  double low = 0.1, high = 2 * sigma + 1;
  for (int i = 0; i < kWidthSteps; i++) {
    const double middle = 0.5 * (low + high);
    (sums(middle).second < sigma * sigma ? low : high) = middle;
  }
  const double sum = sums(high).first;
  for (int i = 0; i <= reach; i++)
    kernel[static_cast<size_t>(i)] =
        static_cast<float>(exp_minus(0.5 * i * i / (high * high)) / sum);
}

double sigma_mm(const Brush& brush) {
  return brush.sigma_mm > 0 ? brush.sigma_mm : brush.radius_mm / 8;
}

NodeBox nodes_within(const LatticePoint& centre, double radius) {
  NodeBox box;
  for (int i = 0; i < 3; i++) {
    box.low[i] = static_cast<int>(std::ceil(centre[i] - radius - 0.5));
    box.high[i] = static_cast<int>(std::floor(centre[i] + radius - 0.5)) + 1;
  }
  return box;
}

// True if the brush's ball meets the lattice. Then the indices of its nodes fit into an int.
bool meets(const Lattice& lattice, const LatticePoint& centre, double radius) {
  for (int i = 0; i < 3; i++)
    if (!(centre[i] + radius > lattice.low()[i] && centre[i] - radius < lattice.high()[i]))
      return false;
  return true;
}

}  // namespace

Reshaper::Reshaper() : writer_(std::make_unique<WriteBack>()) {}
Reshaper::~Reshaper() = default;

std::pair<LatticePoint, double> Reshaper::Cluster::middle() const {
  if (centres.size() == 1) return {centres[0].at, 0};
  const LatticePoint middle{0.5 * (region.low + region.high).matrix().cast<double>()};
  double spread = 0;
  for (const Centre& centre : centres)
    spread = std::max(spread, (centre.at.units - middle.units).norm());
  return {middle, spread};
}

Reshaper::Cluster Reshaper::Cluster::turned(AxisTurn by) const {
  Cluster turned{region.turned(by), centres, own, pending};
  for (Centre& centre : turned.centres)
    centre = {LatticePoint{by.turn(centre.at.units)},
              {by.turn(centre.flat.point_mm), by.turn(centre.flat.normal)},
              {by.turn(centre.alpha.along), by.turn(centre.alpha.across), centre.alpha.shift}};
  return turned;
}

Status check_brush(const Brush& brush, bool below_0) {
  if (!(brush.radius_mm > 0) || !std::isfinite(brush.radius_mm))
    return Error{"a brush's radius must be a positive number of mm"};
  if (!(std::fabs(brush.strength) <= 1))
    return Error{"a brush's strength must be a number from 0 to 1"};
  if (brush.strength < 0 && !below_0)
    return Error{
        "this brush's strength must be a number from 0 to 1; only inflate, crease, pinch and mask "
        "accept a negative strength"};
  if (!(brush.sigma_mm >= 0) || !std::isfinite(brush.sigma_mm))
    return Error{"a brush's sigma must be a number of mm, or 0 for an eighth of the radius"};
  if (!(brush.wall_mm >= 0) || !std::isfinite(brush.wall_mm))
    return Error{"a wall between two fingers must be a number of mm, or 0 for one finger"};
  if (!(brush.spacing >= kMinDabSpacing && brush.spacing <= kMaxDabSpacing))
    return Error{"a brush's spacing must be a number from 0.05 to 2, of its radius"};
  if (brush.mask == MaskVerb::height && brush.flatten_to != FlattenTo::plane)
    return Error{"a mask by height needs a plane with a point and a normal"};
  if (!(brush.mask_material >= 0 && brush.mask_material < kMaxMaterials) ||
      brush.mask_material != std::floor(brush.mask_material))
    return Error{"a brush's mask_material must be the number of a material, from 0 to 63"};
  if (brush.alpha == Alpha::picture && !brush.picture)
    return Error{"a brush with the texture 'picture' needs a picture; give a PNG file"};
  const double length = brush.plane.normal.norm();
  if (!brush.plane.point_mm.allFinite() || !(length > 0) || !std::isfinite(length))
    return Error{"a plane to flatten to needs a finite point and a normal that is not 0"};
  return Ok{};
}

Result<Reshaped> Reshaper::dab(TriDexel& model, FieldVerb verb, const Brush& brush,
                               std::span<const DabPlace> places, double pending_mm3) {
  if (const Status fine = check_brush(brush, verb == FieldVerb::inflate); !fine)
    return Error{fine.error()};
  const Lattice& lattice = model.lattice();
  const double radius = brush.radius_mm / lattice.pitch_mm;
  const double sigma = std::min(sigma_mm(brush) / lattice.pitch_mm, kMaxSigmaCells);
  const double moves = sigma * (verb == FieldVerb::inflate && places.size() > 1 ? kMaxSum : 1);
  gaussian(filters(verb) ? sigma : 0, kernel_);
  const double width = std::max(
      filters(verb) ? static_cast<double>(kernel_.size() - 1) + kBandSigmas * sigma + kBandCells
                    : moves + 2,
      kMinWidth);
  const auto border = static_cast<int>(std::ceil(width)) + static_cast<int>(kernel_.size()) + 1;
  const NodeBox whole = lattice_nodes(lattice).grown(border);

  std::vector<Cluster> clusters;
  for (size_t i = 0; i < places.size(); i++) {
    const DabPlace& place = places[i];
    if (!place.centre_mm.allFinite()) return Error{"a dab's place must be finite"};
    const LatticePoint at = lattice.to_lattice(place.centre_mm);
    if (brush.strength == 0 || !meets(lattice, at, radius)) continue;
    Cluster here{
        nodes_within(at, radius).grown(border).within(whole), {{at, {}, place.alpha}}, i == 0, 0};
    if (to_plane(verb)) {
      std::optional<FlatPlane> plane = place.plane;
      if (!plane && brush.flatten_to == FlattenTo::plane) plane = brush.plane;
      if (!plane)
        if (const auto under = surface_under(model, brush, place.centre_mm)) plane = under->plane;
      if (!plane) continue;
      const double length = plane->normal.norm();
      if (!plane->point_mm.allFinite() || !(length > 0) || !std::isfinite(length))
        return Error{"a plane to flatten to needs a finite point and a normal that is not 0"};
      const Vec3 normal = plane->normal / length;
      const double raised = verb == FieldVerb::build ? sigma : 0;
      here.centres[0].flat = {lattice.to_lattice(plane->point_mm).units + raised * normal, normal};
    }
    // Joins this cluster with all clusters whose regions meet its own, also after it has grown.
    for (size_t k = 0; k < clusters.size();) {
      if (here.region.within(clusters[k].region).empty()) {
        k++;
        continue;
      }
      Cluster& other = clusters[k];
      here.region = {here.region.low.min(other.region.low),
                     here.region.high.max(other.region.high)};
      here.centres.insert(here.centres.end(), other.centres.begin(), other.centres.end());
      here.own |= other.own;
      clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(k));
      k = 0;
    }
    clusters.push_back(std::move(here));
  }

  Reshaped all;
  double own = 0;
  const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
  for (Cluster& cluster : clusters) {
    cluster.pending = pending_mm3 / cell * static_cast<double>(cluster.centres.size()) /
                      static_cast<double>(places.size());
    Result<Reshaped> done = dab_cluster(model, verb, brush, radius, sigma, width, cluster);
    if (!done) return done;
    const Reshaped& what = done.value();
    all.added_mm3 += what.added_mm3;
    all.removed_mm3 += what.removed_mm3;
    all.points += what.points;
    all.clipped |= what.clipped;
    if (!cluster.own) continue;
    all.parts = what.parts;
    own = (what.added_mm3 + what.removed_mm3) / static_cast<double>(cluster.centres.size());
  }
  if (places.size() > 1) all.own = own > 0 ? own / (all.added_mm3 + all.removed_mm3) : 0;
  return all;
}

Result<Reshaped> Reshaper::dab_cluster(TriDexel& model, FieldVerb verb, const Brush& brush,
                                       double radius, double sigma, double width,
                                       const Cluster& given) {
  const NodeBox& box = given.region;
  if (box.size().cast<double>().prod() >= kMaxRegionNodes)
    return Error{"the brush is too large for this pitch: its region has more than 2^31 nodes"};
  const double bytes = static_cast<double>(kBytesPerNode) * box.size().cast<double>().prod();
  if (const double there = bytes > kUncheckedBytes ? available_bytes() : 0;
      there > 0 && bytes > 0.8 * there)
    return Error{
        "the brush is too large for this pitch: its region takes more memory than is free"};
  const auto [centre, spread] = given.middle();
  const AxisTurn turn = turn_along_surface(model, centre, spread + radius);
  const Cluster cluster = given.turned(turn);
  band_.read(model, cluster.region, static_cast<float>(width), turn,
             {.centre = cluster.middle().first,
              .reach = static_cast<float>(spread + radius + kReachSlack),
              .around = std::max(static_cast<float>(kernel_.size() - 1), kSlopeReach)});
  if (band_.blocks().empty() && !to_plane(verb)) return Reshaped{};
  // The maximum depth of a node that may change sides.
  std::optional<float> deepest;
  if (filters(verb))
    deepest = static_cast<float>(std::min(width, kCoreSigmas * sigma + kCoreCells));
  else if (verb == FieldVerb::inflate)
    deepest = static_cast<float>(width);
  const auto compute = [&](std::optional<float> core, double max_sum) {
    return compute_phi_after(model, verb, brush, radius, sigma, cluster, core, max_sum);
  };
  // Few nodes deeper than kNearCore change sides, so the others are computed first.
  if (!(filters(verb) && deepest > kNearCore) || !compute(kNearCore, kNearRise) ||
      changes_beyond(band_, after_, touched_, kNearCore, *deepest, threads_))
    compute(deepest, std::numeric_limits<double>::infinity());
  Reshaped done = writer_->write(model, after_);
  // A brush that keeps the volume restores the dropped volume elsewhere.
  done.clipped = clipped_ && !(brush.keep_volume && verb == FieldVerb::smooth);
  return done;
}

// Computes phi after the verb at the nodes of weigh(). Returns false if it needs more than
// `max_sum` [cells] to keep the volume.
bool Reshaper::compute_phi_after(const TriDexel& model, FieldVerb verb, const Brush& brush,
                                 double radius, double sigma, const Cluster& cluster,
                                 std::optional<float> core, double max_sum) {
  const NodeValues& phi = band_.phi();
  weigh(brush, cluster, radius, verb == FieldVerb::inflate ? kMaxSum : 1, core);
  if (band_.masked()) mask_weights(verb);
  writer_->begin(band_, touched_, threads_);

  const auto strength = static_cast<float>(brush.strength);
  const auto change = [&](auto&& f) {
    run_parallel_pieces(threads_, touched_.size(), [&](size_t b) {
      for_touched(b, [&](size_t node, float weight) {
        after_[node] = f(node, phi[node], strength * weight);
      });
    });
  };
  if (filters(verb)) {
    filter();
    change([&](size_t node, float was, float weight) {
      const float is = was + weight * (second_[node] - was);
      if (verb == FieldVerb::rasp) return std::max(was, is);
      if (verb == FieldVerb::fill) return std::min(was, is);
      return is;
    });
  } else if (verb == FieldVerb::inflate) {
    const auto by = static_cast<float>(sigma);
    change([&](size_t, float was, float weight) { return was - weight * by; });
  } else {
    for (size_t b = 0; b < touched_.size(); b++)
      touched_[b].for_nodes([&](int n) {
        const auto lane = static_cast<size_t>(n);
        const float was = phi[touched_[b].place + lane];
        float by = heights_[b][lane] - was;
        if (verb == FieldVerb::trim) by = std::max(by, 0.0f);
        if (verb == FieldVerb::build) by = std::min(by, 0.0f);
        after_[touched_[b].place + lane] = was + strength * weights_[b][lane] * by;
      });
  }
  // Keeps the nodes beyond the lattice outside, because there is no material.
  const auto outside_stays = [&] {
    const NodeBox all = lattice_nodes(model.lattice()).turned(band_.turn());
    clipped_ = false;
    // True if the surface between a node outside and one inside next to it is now beyond the
    // border. The border is in the middle between the two.
    const auto crosses_border = [&](const Index3& at, size_t node) {
      for (int axis = 0; axis < 3; axis++)
        for (const int side : {-1, 1}) {
          Index3 next = at;
          next[axis] += side;
          if (!all.holds({next, next + 1})) continue;
          const auto step = side * static_cast<std::ptrdiff_t>(band_.stride(axis));
          const size_t inside = node + static_cast<size_t>(step);
          if (after_[inside] < 0 && after_[inside] + after_[node] < -kMinClipped &&
              after_[node] < phi[node])
            return true;
        }
      return false;
    };
    for (const NodeBlock& block : touched_) {
      const Index3 low(block.i, block.j, block.k);
      if (all.holds({low, low + Index3(16, 1, 1)})) continue;
      block.for_nodes([&](int n) {
        const Index3 at = low + Index3(n, 0, 0);
        const size_t node = block.place + static_cast<size_t>(n);
        if (all.holds({at, at + 1})) return;
        clipped_ = clipped_ || crosses_border(at, node);
        after_[node] = std::max(after_[node], 0.0f);
      });
    }
  };
  outside_stays();

  if (brush.keep_volume && verb == FieldVerb::smooth) {
    // phi - lambda w. Secants find the lambda for which the volume changes only by the pending
    // amount. Where a span or a gap appears or vanishes, the volume has a step, which may skip that
    // value. Then the nearest result is used.
    detail::make_items(first_, after_.size());
    for_touched([&](size_t node, float) { first_[node] = after_[node]; });
    const double moved = [&] {
      double sum = 0;
      for_touched([&](size_t node, float) {
        if (std::fabs(phi[node]) < 1) sum += std::fabs(double{after_[node]} - double{phi[node]});
      });
      return sum;
    }();
    double area = 0;
    for (const SurfaceEnd& end : band_.ends()) {
      double weight = 0;
      for (const Centre& centre : cluster.centres)
        weight += falloff_weight(brush.falloff,
                                 (end.place.cast<double>() - centre.at.units).norm() / radius);
      area += std::min(weight, 1.0) * double{std::fabs(end.normal[depth_index(end.axis)])};
    }
    const double max_pending = kPendingRise * brush.strength * area,
                 pending = std::clamp(cluster.pending, -max_pending, max_pending);
    // Returns the change of volume for this lambda, minus the pending volume. 0 is the goal.
    const auto with = [&](double lambda) {
      for_touched([&](size_t node, float weight) {
        if (first_[node] != phi[node])
          after_[node] = first_[node] - static_cast<float>(lambda) * strength * weight;
      });
      outside_stays();
      return writer_->volume(model, after_) - pending;
    };
    double last = 0, last_volume = with(0), best = 0, best_volume = std::fabs(last_volume);
    if (area > 0) {
      double lambda = -last_volume / (brush.strength * area), computed = 0;
      for (int step = 0; step < kMaxVolumeSteps; step++) {
        if (std::fabs(lambda) > max_sum) return false;
        const double volume = with(computed = lambda);
        if (std::fabs(volume) <= best_volume) {
          best = lambda;
          best_volume = std::fabs(volume);
        }
        if (std::fabs(volume) <= kVolumeTolerance * moved || volume == last_volume) break;
        const double next = lambda - volume * (lambda - last) / (volume - last_volume);
        last = lambda;
        last_volume = volume;
        lambda = next;
      }
      if (computed != best) with(best);
    }
  }
  return true;
}

std::optional<Reshaper::SurfaceSample> Reshaper::surface_under(const TriDexel& model,
                                                               const Brush& brush,
                                                               const Vec3& centre_mm) {
  const Lattice& lattice = model.lattice();
  const LatticePoint centre = lattice.to_lattice(centre_mm);
  const double radius = brush.radius_mm / lattice.pitch_mm;
  if (!check_brush(brush, true) || !centre_mm.allFinite() || !meets(lattice, centre, radius))
    return {};
  const NodeBox all = lattice_nodes(lattice);
  band_.read(model, nodes_within(centre, radius).within(all).grown(1), 1);
  Vec3 place = Vec3::Zero(), normal = Vec3::Zero();
  double area = 0;
  std::array<double, kMaxMaterials> areas{};
  for (const SurfaceEnd& end : band_.ends()) {
    const Vec3 at = end.place.cast<double>(), out = end.normal.cast<double>();
    // Each field counts the area in its own direction. The squares of a unit normal's components
    // add up to 1.
    const double weight = falloff_weight(brush.falloff, (at - centre.units).norm() / radius) *
                          std::fabs(out[depth_index(end.axis)]);
    place += weight * at;
    normal += weight * out;
    area += weight;
    areas[end.material] += weight;
  }
  if (!(area > 0) || !(normal.norm() > 1e-6 * area)) return {};
  const auto largest = std::max_element(areas.begin(), areas.end()) - areas.begin();
  return SurfaceSample{{lattice.to_mm(LatticePoint{place / area}), normal.normalized()},
                       static_cast<uint8_t>(largest)};
}

// The nodes that a verb may change, and the brush's falloff there. They are all nodes of the ball,
// or only those with |phi| < core if `core` is given. Falloffs of several places add up, to at most
// `max_sum`.
void Reshaper::weigh(const Brush& brush, const Cluster& cluster, double radius, double max_sum,
                     std::optional<float> core) {
  touched_.clear();
  NodeBox reach = nodes_within(cluster.centres[0].at, radius);
  for (const Centre& centre : cluster.centres) {
    const NodeBox there = nodes_within(centre.at, radius);
    reach = {reach.low.min(there.low), reach.high.max(there.high)};
  }
  reach = reach.within(band_.box().grown(-2));
  struct Weight {
    float weight, height;  // over the planes
  };
  const double radius2 = radius * radius;
  const auto weight_at = [&](const Vec3& place) {
    double sum = 0, height = 0;
    for (const Centre& centre : cluster.centres) {
      const Vec3 offset = place - centre.at.units;
      const double falloff = falloff_of_square(brush.falloff, offset.squaredNorm() / radius2);
      if (falloff == 0) continue;
      const double weight = falloff * alpha_weight(brush, centre.alpha, offset / radius);
      if (weight == 0) continue;
      sum += weight;
      if (!core) height += weight * centre.flat.normal.dot(place - centre.flat.point_mm);
    }
    return Weight{static_cast<float>(std::min(sum, max_sum)), static_cast<float>(height / sum)};
  };
  if (core)
    band_.blocks_within(*core, touched_);
  else
    for (int k = reach.low[2]; k < reach.high[2]; k++)
      for (int j = reach.low[1]; j < reach.high[1]; j++)
        for (size_t b = 0; b < band_.blocks_a_row(); b++) touched_.push_back(band_.block(b, j, k));
  weights_.resize(touched_.size());
  heights_.resize(core ? 0 : touched_.size());
  // Reduces each block to the nodes that may change.
  const auto weigh_block = [&](size_t b) {
    NodeBlock& block = touched_[b];
    unsigned touched = 0;
    if (block.j >= reach.low[1] && block.j < reach.high[1] && block.k >= reach.low[2] &&
        block.k < reach.high[2])
      block.for_nodes([&](int n) {
        const auto lane = static_cast<size_t>(n);
        const int i = block.i + n;
        if (i < reach.low[0] || i >= reach.high[0]) return;
        const Weight what = weight_at(Vec3(i, block.j, block.k).array() + 0.5);
        if (what.weight == 0) return;
        weights_[b][lane] = what.weight;
        if (!core) heights_[b][lane] = what.height;
        touched |= 1u << n;
      });
    block.nodes = static_cast<uint16_t>(touched);
  };
  run_parallel_pieces(threads_, touched_.size(), weigh_block);
  size_t count = 0;
  for (size_t b = 0; b < touched_.size(); b++) {
    if (!touched_[b].nodes) continue;
    touched_[count] = touched_[b];
    weights_[count] = weights_[b];
    if (!core) heights_[count] = heights_[b];
    count++;
  }
  touched_.resize(count);
  // Nodes next to those that may change are also read.
  band_.copy_phi(touched_, after_);
}

// Reduces the weights where the surface is masked.
void Reshaper::mask_weights(FieldVerb verb) {
  NodeValues &share = first_, &distance = second_;
  detail::make_items(share, band_.phi().size());
  detail::make_items(distance, band_.phi().size());
  std::fill(distance.begin(), distance.end(), kFar);
  std::fill(share.begin(), share.end(), 1.0f);
  for (const NodeBlock& block : band_.blocks())
    block.for_nodes([&](int n) {
      const size_t node = block.place + static_cast<size_t>(n);
      share[node] = static_cast<float>(unmasked_share(band_.nearest(node)->paint));
      distance[node] = 0;
    });
  // A verb that works towards a plane also changes nodes whose nearest end is not known. They have
  // the mask of the known node that is the smallest number of steps away.
  if (to_plane(verb)) {
    const Index3 size = band_.box().size();
    const auto spread = [&](size_t node, const Index3& at, int side) {
      for (int axis = 0; axis < 3; axis++) {
        if (side < 0 ? at[axis] == 0 : at[axis] + 1 == size[axis]) continue;
        const size_t next = side < 0 ? node - band_.stride(axis) : node + band_.stride(axis);
        if (distance[next] + 1 >= distance[node]) continue;
        distance[node] = distance[next] + 1;
        share[node] = share[next];
      }
    };
    const Index3 low = band_.box().low;
    for (size_t node = 0; node < distance.size(); node++)
      spread(node, band_.node_at(node) - low, -1);
    for (size_t node = distance.size(); node-- > 0;) spread(node, band_.node_at(node) - low, 1);
  }
  for (size_t b = 0; b < touched_.size(); b++)
    touched_[b].for_nodes([&](int n) {
      const auto lane = static_cast<size_t>(n);
      weights_[b][lane] *= share[touched_[b].place + lane];
    });
}

// Computes G phi at the touched nodes, into second_, with one pass per axis. The last pass computes
// the touched nodes. Each earlier pass computes what the next one reads. This is the least work if
// the first pass is across the surface, and the others along it.
void Reshaper::filter() {
  const auto reach = static_cast<uint32_t>(kernel_.size() - 1);
  std::array<int, 3> axis;
  const std::array<Axis, 3> order = band_.order_by_surface();
  for (size_t pass = 0; pass < 3; pass++) axis[pass] = depth_index(order[pass]);
  band_.rows_of(touched_, rows_[2]);
  band_.spread_rows(rows_[2], axis[2], reach, rows_[1]);
  band_.spread_rows(rows_[1], axis[1], reach, rows_[0]);
  detail::make_items(first_, band_.phi().size());
  detail::make_items(second_, band_.phi().size());
  sum_along(axis[0], band_.phi(), second_, rows_[0]);
  sum_along(axis[1], second_, first_, rows_[1]);
  sum_along(axis[2], first_, second_, rows_[2]);
}

// One pass of the filter over some rows. Values beyond the box equal those at its border.
void Reshaper::sum_along(int axis, const NodeValues& from, NodeValues& to,
                         const std::vector<detail::RowRange>& rows) {
  const Index3 size = band_.box().size();
  const auto nx = static_cast<size_t>(size[0]), ny = static_cast<size_t>(size[1]),
             count = static_cast<size_t>(size[axis]);
  const size_t reach = kernel_.size() - 1;
  constexpr size_t kAtOnce = 16;
  const auto sum_rows = band_kernels().sum_rows;
  // Per thread: the rows that are summed. Along x: one shifted row, with its border nodes repeated
  // around it.
  struct Scratch {
    std::vector<const float*> low, high;
    std::vector<float> wide;
  };
  std::vector<Scratch> scratch(
      static_cast<size_t>(std::max(1, threads_)),
      {std::vector<const float*>(reach + 1), std::vector<const float*>(reach + 1),
       std::vector<float>(axis == 0 ? nx + 2 * reach : 0)});
  const auto sum_row = [&](size_t row, Scratch& own) {
    // At least kAtOnce nodes, because that number is summed together. The surplus is not used.
    const size_t nodes = std::max<size_t>(rows[row].high - rows[row].low, kAtOnce),
                 first = std::min<size_t>(rows[row].low, nx - nodes);
    const float* in = from.data() + row * nx;
    if (axis == 0) {
      // Node i is at reach + i, for all nodes that are summed.
      const size_t low = first - std::min(first, reach), high = std::min(nx, first + nodes + reach);
      std::fill_n(own.wide.data() + low, reach, in[0]);
      std::fill_n(own.wide.data() + high + reach, reach, in[nx - 1]);
      std::copy_n(in + low, high - low, own.wide.data() + reach + low);
      in = own.wide.data() + reach;
    }
    const size_t at = axis == 1 ? row % ny : row / ny, step = band_.stride(axis);
    for (size_t m = 0; m <= reach; m++) {
      own.low[m] = in + first - (axis == 0 ? m : std::min(m, at) * step);
      own.high[m] = in + first + (axis == 0 ? m : std::min(m, count - 1 - at) * step);
    }
    sum_rows(own.low.data(), own.high.data(), kernel_, nodes, to.data() + row * nx + first);
  };
  run_parallel_slices(threads_, rows.size() / ny, [&](size_t k, size_t thread) {
    for (size_t row = k * ny; row < (k + 1) * ny; row++)
      if (rows[row].high) sum_row(row, scratch[thread]);
  });
}

}  // namespace kibori
