// SPDX-License-Identifier: MIT
#include <kibori/reshape/node_band.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include <kibori/base/check.h>
#include <kibori/base/parallel.h>
#include <kibori/dexel/normal_code.h>
#include <kibori/reshape/band_kernels.h>

namespace kibori {

using namespace detail;

namespace {

// If |d|^2 - kSideways2 exceeds the square of the width, phi is at least the width.
constexpr float kSideways2 = 1;

constexpr size_t kBlock = 16;
constexpr std::array<Axis, 3> kEndOrder{Axis::z, Axis::y, Axis::x};
static_assert(kMaxMaterials <= 64);

// True if an end is major: see node_band.h.
template <Axis axis>
bool is_major(uint32_t normal) {
  const auto square = [](uint32_t snorm) {
    const int64_t n = static_cast<int16_t>(snorm);
    return n * n;
  };
  const int64_t u2 = square(normal & 0xffffu), v2 = square(normal >> 16),
                depth2 = int64_t{32767} * 32767 - u2 - v2, max_squared = std::max({u2, v2, depth2});
  // The limits 0.75 and 0.87, squared.
  const auto sees = [&](int64_t component2) { return 16 * component2 >= 9 * max_squared; };
  const auto sees_well = [&](int64_t component2) { return 4 * component2 > 3 * max_squared; };
  switch (axis) {
    case Axis::z:
      return sees(depth2);
    case Axis::y:  // u is z
      return sees(depth2) && !sees_well(u2);
    case Axis::x:  // u is y, v is z
      return sees(depth2) && !sees_well(u2) && !sees_well(v2);
  }
}

// decode_normal without the normalisation, in half the time. (u, v, depth) is already a unit
// vector, unless (u, v) alone is longer than 1.
template <Axis axis>
Eigen::Vector3f decode_unit(uint32_t code, bool at_out) {
  constexpr double kUnit = 1 / 32767.0;
  const double u = static_cast<int16_t>(code & 0xffffu) * kUnit;
  const double v = static_cast<int16_t>(code >> 16) * kUnit;
  const double depth2 = 1 - u * u - v * v;
  if (depth2 < 0) return decode_normal(code, axis, at_out).cast<float>();
  const auto depth = static_cast<float>(std::sqrt(depth2));
  Eigen::Vector3f normal;
  normal[u_index(axis)] = static_cast<float>(u);
  normal[v_index(axis)] = static_cast<float>(v);
  normal[depth_index(axis)] = at_out ? depth : -depth;
  return normal;
}

}  // namespace

// Call before the first slice of a field.
void detail::BandScratch::prepare(const BandSlice& slice) {
  const size_t blocks = slice.rows * slice.cols,
               seeds = slice.rows * (slice.cols + 2 * slice.margin),
               rows = blocks + 2 * (slice.window + 1) * slice.cols;
  seed_end.resize(seeds);
  row_end.resize(rows);
  const bool other = slice.too_far != too_far;
  too_far = slice.too_far;
  if (seed_distance2.resize(seeds) || other)
    std::fill_n(seed_distance2.data()->lane, seed_distance2.size() * kBlock, too_far);
  else
    clear_seeds();
  if (row_distance2.resize(rows) || other)
    std::fill_n(row_distance2.data()->lane, row_distance2.size() * kBlock, too_far);
  cols = slice.cols;
  margin = slice.margin;
  seeded.assign(blocks, 0);
  seeds_near.resize(blocks);
  rows_near.resize(blocks);
  prepared = true;
}

void detail::BandScratch::clear_seeds() {
  for (size_t first = 0; first < seeded.size(); first += cols) {
    FloatRow* const row = &seed_distance2[first / cols * (cols + 2 * margin) + margin];
    for (size_t c = 0; c < cols; c++)
      if (seeded[first + c]) std::fill_n(row[c].lane, kBlock, too_far);
  }
}

// Counts ends on some rays of each field. The field whose rays run along the surface has the
// fewest.
AxisTurn turn_along_surface(const TriDexel& model, const LatticePoint& centre, double reach) {
  constexpr int kRays = 5;  // on each side of the centre
  const double step = std::max(1.0, reach / kRays);
  std::array<int, 3> ends{};
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis).view();
    for (int dv = -kRays; dv <= kRays; dv++)
      for (int du = -kRays; du <= kRays; du++) {
        const double across2 = step * step * (du * du + dv * dv);
        const double u = std::floor(centre[u_index(axis)] + step * du),
                     v = std::floor(centre[v_index(axis)] + step * dv);
        if (across2 > reach * reach || !(u >= field.u_begin() && u < field.u_end()) ||
            !(v >= field.v_begin() && v < field.v_end()))
          continue;
        const double middle = centre[depth_index(axis)], chord = std::sqrt(reach * reach - across2);
        const auto within = [&](float depth) {
          return static_cast<int>(std::fabs(double{depth} - middle) <= chord);
        };
        field.for_spans(static_cast<int>(u), static_cast<int>(v), [&](const Span& span) {
          ends[static_cast<size_t>(axis)] += within(span.in) + within(span.out);
        });
      }
  }
  return AxisTurn(
      kAxes[static_cast<size_t>(std::min_element(ends.begin(), ends.end()) - ends.begin())]);
}

void NodeBand::read(const TriDexel& model, const NodeBox& box, float width, AxisTurn turn,
                    const BandPart& part) {
  turn_ = turn;
  read_wanted(model, box, width, part, nullptr);
}

void NodeBand::read_at(const TriDexel& model, const NodeBox& box, float width,
                       const std::vector<NodeBlock>& nodes, AxisTurn turn) {
  turn_ = turn;
  read_wanted(model, box, width, {}, &nodes);
}

void NodeBand::read_wanted(const TriDexel& model, const NodeBox& box, float width,
                           const BandPart& part, const std::vector<NodeBlock>* wanted) {
  const BandKernels kernels = band_kernels();
  box_ = box;
  const Index3 extent = box.size().max(0);
  blocks_ = (static_cast<size_t>(extent[0]) + kBlock - 1) / kBlock;
  nx_ = blocks_ * kBlock;
  ny_ = static_cast<size_t>(extent[1]);
  nz_ = static_cast<size_t>(extent[2]);
  box_.high[0] = box_.low[0] + static_cast<int>(nx_);
  width_ = width;
  centre_ = part.centre.units.cast<float>();
  farthest_ = std::sqrt(width * width + kSideways2);
  reach_ = part.reach;
  around_ = part.around;
  KIBORI_CHECK(nx_ * ny_ * nz_ < UINT32_MAX && width < 250);  // rows_near holds bytes
  const size_t rows = ny_ * nz_ * blocks_;
  make_items(phi_, nx_ * ny_ * nz_);
  distance2_.resize(rows);
  nearest_.resize(rows);
  known_.assign(rows, 0);
  ends_.clear();
  known_blocks_.clear();
  all_wanted_ = !wanted;
  if (box.empty()) return;
  if (wanted) want(*wanted);
  // Distances of the nodes from the centre; for blocks, at their nearest node.
  for (int i = 0; i < 3; i++) {
    const size_t count = i == 0 ? blocks_ : i == 1 ? ny_ : nz_, nodes = i == 0 ? kBlock : 1;
    std::vector<float>& away = away_[static_cast<size_t>(i)];
    std::vector<float>& ends_away = ends_away_[static_cast<size_t>(i)];
    away.clear();
    ends_away.clear();
    for (size_t n = 0; n < count; n++) {
      const float low = static_cast<float>(box_.low[i]) + static_cast<float>(n * nodes) + 0.5f,
                  high = low + static_cast<float>(nodes - 1),
                  off = std::max(0.0f, std::max(low - centre_[i], centre_[i] - high) - around_);
      away.push_back(off * off);
      const float nearer = std::max(0.0f, off - farthest_);
      ends_away.push_back(nearer * nearer);
    }
  }
  run_parallel(threads_, 4, [&](size_t i) {
    switch (i) {
      case 0:
        return read_ends<Axis::x>(model);
      case 1:
        return read_ends<Axis::y>(model);
      case 2:
        return read_ends<Axis::z>(model);
      default:
        return read_spans(model);
    }
  });
  join_ends();
  for (const Axis axis : kEndOrder) search(axis);
  offer_minor_ends();
  list_known(part.margin);
  compute_sides(part.margin);
  run_parallel_ranges(threads_, known_blocks_.size(), [&](size_t first, size_t number) {
    kernels.measure(
        {known_blocks_.data() + first, number, ends_.data(), nearest_.data(), width_, phi_.data()});
  });
}

// Selects the nodes to read, and finds the depths of their ends. Call it before anything else is
// read.
void NodeBand::want(const std::vector<NodeBlock>& nodes) {
  wanted_.assign(known_.size(), 0);
  const auto columns = [&](int axis) {
    return static_cast<size_t>((box_.size()[axis] + kColumn - 1) / kColumn);
  };
  for (const Axis axis : kAxes)
    depths_[static_cast<size_t>(axis)].assign(columns(u_index(axis)) * columns(v_index(axis)), {});
  for (const NodeBlock& block : nodes) {
    wanted_[block.place / kBlock] = block.nodes;
    const Index3 at = box_.node_at(block.place) - box_.low;
    for (const int n : {block.first(), block.last()})
      for (const Axis axis : kAxes) {
        const Index3 node = at + Index3(n, 0, 0);
        const auto u = static_cast<size_t>(node[u_index(axis)] / kColumn),
                   v = static_cast<size_t>(node[v_index(axis)] / kColumn);
        depths_[static_cast<size_t>(axis)][v * columns(u_index(axis)) + u].include(
            static_cast<float>(box_.low[depth_index(axis)] + node[depth_index(axis)]) + 0.5f);
      }
  }
  // The end nearest to a node may be on a ray of a neighbouring column, too.
  const auto margin = static_cast<size_t>(std::ceil(farthest_ / static_cast<float>(kColumn)));
  std::vector<DepthRange> own;
  for (const Axis axis : kAxes) {
    std::vector<DepthRange>& depths = depths_[static_cast<size_t>(axis)];
    own = depths;
    const size_t nu = columns(u_index(axis)), nv = columns(v_index(axis));
    for (size_t v = 0; v < nv; v++)
      for (size_t u = 0; u < nu; u++) {
        const DepthRange& range = own[v * nu + u];
        if (range.low > range.high) continue;
        for (size_t q = v - std::min(v, margin); q <= std::min(nv - 1, v + margin); q++)
          for (size_t p = u - std::min(u, margin); p <= std::min(nu - 1, u + margin); p++) {
            depths[q * nu + p].include(range.low - farthest_);
            depths[q * nu + p].include(range.high + farthest_);
          }
      }
  }
}

// The depths at which ends of a ray may be nearest to a node.
DepthRange NodeBand::wanted_depths(Axis axis, int u, int v) const {
  if (all_wanted_) return {-kFar, kFar};
  const int a = u_index(axis), b = v_index(axis);
  const auto nu = static_cast<size_t>((box_.size()[a] + kColumn - 1) / kColumn);
  return depths_[static_cast<size_t>(axis)][static_cast<size_t>((v - box_.low[b]) / kColumn) * nu +
                                            static_cast<size_t>((u - box_.low[a]) / kColumn)];
}

void NodeBand::blocks_within(float depth, std::vector<NodeBlock>& to) const {
  blocks_within(depth, to, [](NodeBlock&) {});
}

auto NodeBand::nodes_within_depth() -> uint32_t (*)(const float*, float) {
  return band_kernels().nodes_within_depth;
}

void NodeBand::rows_of(const std::vector<NodeBlock>& nodes, std::vector<RowRange>& to) const {
  const auto nx = static_cast<uint32_t>(nx_);
  to.assign(ny_ * nz_, {});
  for (const NodeBlock& block : nodes) {
    const uint32_t row = block.place / nx, first = block.place - row * nx;
    to[row].include({first + static_cast<uint32_t>(block.first()),
                     first + static_cast<uint32_t>(block.last()) + 1});
  }
}

void NodeBand::spread_rows(const std::vector<RowRange>& from, int axis, uint32_t reach,
                           std::vector<RowRange>& to) const {
  const auto nx = static_cast<uint32_t>(nx_);
  to.assign(ny_ * nz_, {});
  if (axis == 0) {
    for (size_t row = 0; row < ny_ * nz_; row++)
      if (from[row].high)
        to[row] = {from[row].low - std::min(from[row].low, reach),
                   std::min(nx, from[row].high + reach)};
    return;
  }
  const auto spread_row = [&](size_t row, size_t at, size_t count, size_t step) {
    if (!from[row].high) return;
    const size_t low = std::min<size_t>(at, reach), high = std::min<size_t>(count - 1 - at, reach);
    for (size_t r = row - low * step; r <= row + high * step; r += step) to[r].include(from[row]);
  };
  if (axis == 1) {
    run_parallel_slices(threads_, nz_, [&](size_t k, size_t) {
      for (size_t j = 0; j < ny_; j++) spread_row(k * ny_ + j, j, ny_, 1);
    });
    return;
  }
  constexpr size_t kRows = 8;  // of a cache line
  run_parallel_slices(threads_, (ny_ + kRows - 1) / kRows, [&](size_t piece, size_t) {
    for (size_t k = 0; k < nz_; k++)
      for (size_t j = piece * kRows; j < std::min(ny_, (piece + 1) * kRows); j++)
        spread_row(k * ny_ + j, k, nz_, ny_);
  });
}

void NodeBand::copy_phi(const std::vector<NodeBlock>& nodes, NodeValues& to) {
  constexpr uint32_t kReach = 2;
  rows_of(nodes, rows_[0]);
  spread_rows(rows_[0], 1, kReach, rows_[1]);
  spread_rows(rows_[1], 2, kReach, rows_[0]);
  spread_rows(rows_[0], 0, kReach, rows_[1]);
  copy_rows(rows_[1], to);
}

void NodeBand::copy_rows(const std::vector<RowRange>& rows, NodeValues& to) const {
  make_items(to, phi_.size());
  run_parallel_slices(threads_, nz_, [&](size_t slice, size_t) {
    for (size_t row = slice * ny_; row < (slice + 1) * ny_; row++)
      if (const auto [low, high] = rows[row]; low < high)
        std::copy_n(phi_.data() + row * nx_ + low, high - low, to.data() + row * nx_ + low);
  });
}

std::array<Axis, 3> NodeBand::order_by_surface() const {
  std::array<Axis, 3> order = kEndOrder;
  std::stable_sort(order.begin(), order.end(), [&](Axis a, Axis b) {
    return fields_[static_cast<size_t>(a)].ends.size() >
           fields_[static_cast<size_t>(b)].ends.size();
  });
  return order;
}

// Lists the known blocks in order. If not all sides are computed, rows_[1] gets the nodes within
// `margin` of them along x and y.
void NodeBand::list_known(uint32_t margin) {
  const bool all = margin == BandPart::kAll;
  if (!all) rows_[1].assign(ny_ * nz_, {});
  const size_t blocks = ny_ * blocks_;  // per slice
  // Calls f(at) for each block of the slice with known nodes. Most blocks have none, so four are
  // tested together.
  const auto for_known = [&](size_t k, auto&& f) {
    const uint16_t* const known = known_.data() + k * blocks;
    size_t at = 0;
    while (at < blocks) {
      uint64_t four = 1;
      if (at + 4 <= blocks) std::memcpy(&four, known + at, sizeof four);
      const size_t end = std::min(at + 4, blocks);
      if (four)
        for (size_t i = at; i < end; i++)
          if (known[i]) f(i);
      at = end;
    }
  };
  std::vector<size_t> end(nz_);  // end of each slice in the list
  run_parallel_slices(threads_, nz_, [&](size_t k, size_t) {
    size_t count = 0;
    for_known(k, [&](size_t) { count++; });
    end[k] = count;
  });
  std::partial_sum(end.begin(), end.end(), end.begin());
  make_items(known_blocks_, end.back());
  run_parallel_slices(threads_, nz_, [&](size_t k, size_t) {
    NodeBlock* to = known_blocks_.data() + (k > 0 ? end[k - 1] : 0);
    size_t row = 0;
    for_known(k, [&](size_t at) {
      while (at >= (row + 1) * blocks_) row++;
      const size_t in_row = at - row * blocks_;
      NodeBlock& known = *to++ =
          block(in_row, box_.low[1] + static_cast<int>(row), box_.low[2] + static_cast<int>(k));
      known.nodes = known_[k * blocks + at];
      if (all) return;
      const auto first = static_cast<uint32_t>(in_row * kBlock),
                 low = first + static_cast<uint32_t>(known.first()),
                 high = first + static_cast<uint32_t>(known.last()) + 1 + margin;
      const RowRange near{low - std::min(low, margin), std::min(static_cast<uint32_t>(nx_), high)};
      const size_t last = std::min(ny_ - 1, row + margin);
      for (size_t r = row - std::min<size_t>(row, margin); r <= last; r++)
        rows_[1][k * ny_ + r].include(near);
    });
  });
}

// Computes which nodes are inside. If `margin` is not kAll, it skips nodes far from the surface,
// which are most of a ball.
void NodeBand::compute_sides(uint32_t margin) {
  const bool all = margin == BandPart::kAll;
  if (!all) spread_rows(rows_[1], 2, margin, computed_);
  const auto kernel = band_kernels().compute_sides;
  run_parallel_slices(threads_, nz_, [&](size_t k, size_t) {
    BandPlane own = plane(k);
    own.computed = all ? nullptr : computed_.data() + k * ny_;
    kernel(own);
  });
}

// Reads the z field's spans.
void NodeBand::read_spans(const TriDexel& model) {
  const FieldSnapshot& field = model.field(turn_.old(Axis::z)).view();
  const NodeBox there = box_.within(lattice_nodes(model.lattice()).turned(turn_));
  rays_.assign(ny_ * blocks_, {});
  span_layers_.clear();
  for (int j = there.low[1]; j < there.high[1]; j++)
    for (size_t b = 0; b < blocks_; b++) {
      RayItems& rays = rays_[static_cast<size_t>(j - box_.low[1]) * blocks_ + b];
      rays.first = static_cast<uint32_t>(span_layers_.size());
      const int i0 = box_.low[0] + static_cast<int>(b * kBlock);
      for (int i = std::max(i0, there.low[0]);
           i < std::min(i0 + static_cast<int>(kBlock), there.high[0]); i++) {
        uint32_t at = 0;
        field.for_spans(i, j, [&](const Span& span) {
          if (at == rays.count) {
            rays.count++;
            BandSpans& layer = span_layers_.emplace_back();
            std::fill_n(layer.in.lane, kBlock, kFar);
            std::fill_n(layer.out.lane, kBlock, -kFar);
          }
          BandSpans& layer = span_layers_[rays.first + at++];
          layer.in.lane[i - i0] = span.in;
          layer.out.lane[i - i0] = span.out;
        });
      }
    }
}

// Adds the ends of the ray at (u, v) that may be nearest to a node. Calls f(end, depth) for each
// major end.
template <Axis axis, class F>
void NodeBand::add_ends(const FieldSnapshot& field, int u, int v, FieldEnds& to, F&& f) const {
  constexpr int d = depth_index(axis);
  const DepthRange wanted = wanted_depths(axis, u, v);
  if (wanted.low > wanted.high) return;
  // Squared distances from the centre across the ray. near2 is what remains of the squared reach
  // for the distance along the ray.
  const auto off2 = [&](float place, int i) {
    const float distance = std::max(0.0f, std::fabs(place - centre_[i]) - around_);
    return distance * distance;
  };
  const float reach = reach_ + farthest_,
              u_off2 = off2(static_cast<float>(u) + 0.5f, u_index(axis)),
              v_off2 = off2(static_cast<float>(v) + 0.5f, v_index(axis)),
              near2 = reach * reach - u_off2 - v_off2;
  if (near2 < 0) return;
  const auto lowest = static_cast<float>(box_.low[d]), beyond = static_cast<float>(box_.high[d]);
  SurfaceEnd end;
  end.place[u_index(axis)] = static_cast<float>(u) + 0.5f;
  end.place[v_index(axis)] = static_cast<float>(v) + 0.5f;
  end.axis = axis;
  const auto add = [&](float depth, uint32_t normal, bool at_out, uint8_t material, Color paint) {
    // Skips an end if neither node of its lattice edge is in the box.
    if (depth - 0.5f < lowest - 1 || depth - 0.5f >= beyond) return;
    if (depth < wanted.low || depth > wanted.high || off2(depth, d) > near2) return;
    end.place[d] = depth;
    end.normal = decode_unit<axis>(normal, at_out);
    end.material = material;
    end.paint = paint;
    to.materials |= uint64_t{1} << material;
    to.masked |= mask_of(paint) != 0;
    if (!is_major<axis>(normal)) {
      to.minor.push_back(end);
      return;
    }
    f(static_cast<uint32_t>(to.ends.size()), depth);
    to.ends.push_back(end);
  };
  // Touching spans are two materials without a surface between them.
  Span last{-kFar, -kFar, 0, 0, 0, 0, 0};
  field.for_spans(u, v, [&](const Span& span) {
    if (span.in != last.out) {
      if (last.in < last.out) add(last.out, last.normal_out, true, last.material, last.paint_out);
      add(span.in, span.normal_in, false, span.material, span.paint_in);
    }
    last = span;
  });
  if (last.in < last.out) add(last.out, last.normal_out, true, last.material, last.paint_out);
}

// Reads a field's ends that may be nearest to a node within reach.
template <Axis axis>
void NodeBand::read_ends(const TriDexel& model) {
  const FieldSnapshot& field = model.field(turn_.old(axis)).view();
  FieldEnds& to = fields_[static_cast<size_t>(axis)];
  const NodeBox there = box_.within(lattice_nodes(model.lattice()).turned(turn_));
  to.ends.clear();
  to.minor.clear();
  to.materials = 0;
  to.masked = false;
  to.layers.clear();
  to.of_rows.assign(axis == Axis::z ? ny_ : nz_, {});
  to.of_rays.assign(to.of_rows.size() * (axis == Axis::x ? ny_ : blocks_), {});
  to.rays.assign(to.of_rays.size(), {});
  if constexpr (axis == Axis::x) {
    for (int k = there.low[2]; k < there.high[2]; k++)
      for (int j = there.low[1]; j < there.high[1]; j++) {
        const size_t row = static_cast<size_t>(k - box_.low[2]),
                     at = row * ny_ + static_cast<size_t>(j - box_.low[1]);
        RayItems& ray = to.rays[at];
        ray.first = static_cast<uint32_t>(to.ends.size());
        add_ends<axis>(field, j, k, to, [&](uint32_t, float depth) {
          ray.count++;
          to.of_rows[row].include(depth);
          to.of_rays[at].include(depth);
        });
      }
    return;
  }
  // Rows along y for z rays, along z for y rays.
  constexpr bool of_z = axis == Axis::z;
  constexpr int r = of_z ? 1 : 2;
  for (int row = there.low[r]; row < there.high[r]; row++)
    for (size_t b = 0; b < blocks_; b++) {
      const size_t block = static_cast<size_t>(row - box_.low[r]) * blocks_ + b;
      RayItems& rays = to.rays[block];
      rays.first = static_cast<uint32_t>(to.layers.size());
      const int i0 = box_.low[0] + static_cast<int>(b * kBlock);
      for (int i = std::max(i0, there.low[0]);
           i < std::min(i0 + static_cast<int>(kBlock), there.high[0]); i++) {
        const int u = of_z ? i : row, v = of_z ? row : i;
        uint32_t at = 0;
        add_ends<axis>(field, u, v, to, [&](uint32_t end, float depth) {
          if (at == rays.count) {
            rays.count++;
            EndLayer& layer = to.layers.emplace_back();
            std::fill_n(layer.depth.lane, kBlock, kFar);
            std::fill_n(layer.end.lane, kBlock, -1);
          }
          EndLayer& layer = to.layers[rays.first + at++];
          to.of_rows[static_cast<size_t>(row - box_.low[r])].include(depth);
          to.of_rays[block].include(depth);
          layer.depth.lane[i - i0] = depth;
          layer.end.lane[i - i0] = static_cast<int32_t>(end);
        });
      }
    }
}

// Joins the fields' ends into one list: the major ones of z, y, x, then the others.
void NodeBand::join_ends() {
  std::array<size_t, 3> first{}, minor{};
  size_t count = 0;
  for (size_t i = 0; i < 3; i++) {
    first[i] = count;
    count += fields_[static_cast<size_t>(kEndOrder[i])].ends.size();
  }
  first_minor_ = count;
  for (size_t i = 0; i < 3; i++) {
    minor[i] = count;
    count += fields_[static_cast<size_t>(kEndOrder[i])].minor.size();
  }
  masked_ = fields_[0].masked || fields_[1].masked || fields_[2].masked;
  const uint64_t materials = fields_[0].materials | fields_[1].materials | fields_[2].materials;
  only_material_.reset();
  if (std::has_single_bit(materials))
    only_material_ = static_cast<uint8_t>(std::countr_zero(materials));
  ends_.resize(count);
  run_parallel(threads_, 3, [&](size_t i) {
    FieldEnds& field = fields_[static_cast<size_t>(kEndOrder[i])];
    const auto before = static_cast<uint32_t>(first[i]);
    for (EndLayer& layer : field.layers)
      for (int32_t& end : layer.end.lane) end += static_cast<int32_t>(before);
    if (kEndOrder[i] == Axis::x)
      for (RayItems& ray : field.rays) ray.first += before;
    std::copy(field.ends.begin(), field.ends.end(),
              ends_.begin() + static_cast<std::ptrdiff_t>(before));
    std::copy(field.minor.begin(), field.minor.end(),
              ends_.begin() + static_cast<std::ptrdiff_t>(minor[i]));
  });
}

// Offers each minor end to the two nodes of its lattice edge. Each thread handles its own slices.
void NodeBand::offer_minor_ends() {
  const float too_far = width_ * width_ + kSideways2, reach2 = reach_ * reach_;
  const auto slabs = static_cast<size_t>(std::max(1, threads_));
  run_parallel(threads_, slabs, [&](size_t slab) {
    const size_t low = nz_ * slab / slabs, high = nz_ * (slab + 1) / slabs;
    for (size_t e = first_minor_; e < ends_.size(); e++) {
      const SurfaceEnd& end = ends_[e];
      const int d = depth_index(end.axis);
      Index3 node = end.place.array().floor().cast<int>();
      node[d] = static_cast<int>(std::floor(1 + (end.place[d] - 0.5f))) - 1;
      for (int step = 0; step < 2; step++, node[d]++) {
        if (node[d] < box_.low[d] || node[d] >= box_.high[d]) continue;
        const Eigen::Array<size_t, 3, 1> at = (node - box_.low).cast<size_t>();
        if (at[2] < low || at[2] >= high) continue;
        const size_t block = (at[2] * ny_ + at[1]) * blocks_ + at[0] / kBlock,
                     lane = at[0] % kBlock;
        if (!all_wanted_ && !wanted_[block]) continue;
        if (!(away_[0][at[0] / kBlock] + away_[1][at[1]] + away_[2][at[2]] < reach2)) continue;
        if (!known_[block]) {
          std::fill_n(distance2_[block].lane, kBlock, too_far);
          std::fill_n(nearest_[block].lane, kBlock, -1);
        }
        const float off = static_cast<float>(node[d]) + 0.5f - end.place[d];
        if (!(off * off < distance2_[block].lane[lane])) continue;
        distance2_[block].lane[lane] = off * off;
        nearest_[block].lane[lane] = static_cast<int32_t>(e);
        known_[block] = static_cast<uint16_t>(known_[block] | 1u << lane);
      }
    }
  });
}

void NodeBand::search(Axis axis) {
  const FieldEnds& field = fields_[static_cast<size_t>(axis)];
  if (field.ends.empty()) return;
  BandSlice slice;
  slice.rows = axis == Axis::z ? ny_ : nz_;
  slice.cols = axis == Axis::x ? ny_ : blocks_;
  slice.step = axis == Axis::x ? kBlock : 1;
  slice.too_far = width_ * width_ + kSideways2;
  slice.farthest = farthest_;
  slice.window = static_cast<size_t>(std::ceil(slice.farthest)) - 1;
  slice.margin = axis == Axis::x ? slice.window + 1 : slice.window / kBlock + 1;
  slice.rays = field.rays.data();
  slice.layers = axis == Axis::x ? nullptr : field.layers.data();
  slice.ends = ends_.data();
  slice.row_ends = field.of_rows.data();
  slice.ray_ends = field.of_rays.data();
  slice.length = axis == Axis::x ? static_cast<float>(kBlock - 1) : 0;
  slice.distance2 = distance2_.data();
  slice.nearest = nearest_.data();
  slice.known = known_.data();
  slice.wanted = all_wanted_ ? nullptr : wanted_.data();
  slice.row_step = axis == Axis::z ? blocks_ : ny_ * blocks_;
  slice.col_step = axis == Axis::x ? blocks_ : 1;
  slice.reach2 = reach_ * reach_;
  slice.row_away = away_[axis == Axis::z ? 1 : 2].data();
  slice.col_away = away_[axis == Axis::x ? 1 : 0].data();
  slice.row_ends_away = ends_away_[axis == Axis::z ? 1 : 2].data();
  slice.col_ends_away = ends_away_[axis == Axis::x ? 1 : 0].data();
  scratch_.resize(static_cast<size_t>(std::max(1, threads_)));
  for (BandScratch& scratch : scratch_) scratch.prepared = false;
  const auto kernel = band_kernels().search;
  const int across = axis == Axis::z ? 2 : axis == Axis::y ? 1 : 0;
  const float first = static_cast<float>(box_.low[across]) + 0.5f;
  const size_t step = axis == Axis::z ? ny_ * blocks_ : axis == Axis::y ? blocks_ : 1;
  const std::vector<float>& away = away_[static_cast<size_t>(across)];
  run_parallel_slices(threads_, away.size(), [&](size_t i, size_t thread) {
    if (!(away[i] < slice.reach2)) return;
    BandSlice own = slice;
    own.scratch = &scratch_[thread];
    if (!own.scratch->prepared) own.scratch->prepare(slice);
    own.depth = first + static_cast<float>(axis == Axis::x ? i * kBlock : i);
    own.first = i * step;
    own.away = away[i];
    kernel(own);
  });
}

BandPlane NodeBand::plane(size_t k) {
  BandPlane plane;
  plane.rows = ny_;
  plane.blocks = blocks_;
  plane.nx = nx_;
  plane.z = static_cast<float>(box_.low[2] + static_cast<int>(k)) + 0.5f;
  plane.width = width_;
  plane.rays = rays_.data();
  plane.spans = span_layers_.data();
  plane.phi = phi_.data() + k * ny_ * nx_;
  plane.row_away = away_[1].data();
  plane.block_away = away_[0].data();
  plane.away = away_[2][k];
  plane.reach2 = reach_ * reach_;
  plane.wanted = all_wanted_ ? nullptr : wanted_.data() + k * ny_ * blocks_;
  return plane;
}

}  // namespace kibori
