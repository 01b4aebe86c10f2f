// SPDX-License-Identifier: MIT
// Finds the nearest major end of each node, field by field. The ends of a field are on rays through
// the nodes. So the squared distance from a node is a sum over the axes, and each term can be
// minimised separately:
//
//   d^2 = (along the ray)^2 + (nodes across, first axis)^2 + (nodes across, second axis)^2
//
// A slice is a plane of nodes across the rays. Three passes search it, 16 nodes at once: the node's
// own ray; the other rays in its row; the other rows. A pass stops where the distance to the next
// ray alone exceeds the best distance so far.
//
//   z rays, y rays   a slice has one z or one y; its rows run along x, in blocks of 16 nodes
//   x rays           a slice is 16 nodes thick along x; a block holds the 16 nodes of one ray
#include <kibori/reshape/band_kernels.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/vector_unit.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/reshape/band_kernels.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

#ifndef KIBORI_BAND_KERNELS_SHARED
#define KIBORI_BAND_KERNELS_SHARED
namespace kibori {

using namespace detail;

// |phi| [cells] of an inside node is at least this, so that a node exactly on the surface keeps its
// sign.
inline constexpr float kMinDepth = 1e-6f;

}  // namespace kibori
#endif

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

HWY_INLINE void Store(VF x, FloatRow& to, size_t g) { hn::Store(x, DF(), to.lane + g * kLanes); }
HWY_INLINE void Store(VI x, IndexRow& to, size_t g) { hn::Store(x, DI(), to.lane + g * kLanes); }
HWY_INLINE VF Lanes(const FloatRow& of, size_t g) { return hn::Load(DF(), of.lane + g * kLanes); }
HWY_INLINE VI Lanes(const IndexRow& of, size_t g) { return hn::Load(DI(), of.lane + g * kLanes); }

// Forces a full vector load. Compilers may load only the lanes of a mask, merged into another
// vector. Then each load waits for its mask and for the previous load, which takes three times as
// long.
HWY_INLINE VI Loaded(VI x) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3 && (HWY_COMPILER_GCC || HWY_COMPILER_CLANG)
  __asm__("" : "+v"(x.raw));
#endif
  return x;
}

// The nearest end so far of a group of nodes.
struct Nearest {
  VF distance2;
  VI end;

  // True if no end can be nearer whose squared distance along one axis is `apart2`.
  HWY_INLINE bool beats(VF apart2) const { return hn::AllTrue(DF(), hn::Le(distance2, apart2)); }
  HWY_INLINE void offer(VF other2, VI other) {
    other = Loaded(other);
    const MF nearer = hn::Lt(other2, distance2);
    distance2 = hn::Min(other2, distance2);
    end = hn::IfThenElse(hn::RebindMask(DI(), nearer), other, end);
  }
  // Offers the nearer of two ends, at a squared distance larger by `apart2`. The two are compared
  // first, so that only one comparison depends on the previous offer.
  HWY_INLINE void offer(Nearest one, const Nearest& two, VF apart2) {
    one.offer(two.distance2, two.end);
    offer(hn::Add(one.distance2, apart2), one.end);
  }
};

// Number of nodes in a line that the nearest of these ends may serve. The first of them is the node
// to which `distance2` belongs. Returns 0 if that node is too far.
HWY_INLINE size_t NodesWithin(const BandSlice& s, VF distance2) {
  const float room = s.too_far - hn::GetLane(hn::MinOfLanes(DF(), distance2));
  return room > 0 ? std::min(s.window, static_cast<size_t>(std::sqrt(room))) + 1 : 0;
}

// Calls offer(apart^2, off) for the nodes that are 1, 2, ... apart, while an end there can be
// nearer. `off` is apart times `step`. Nodes are offered in pairs, so the last one may be one
// beyond the window. This surplus offer changes nothing.
template <class Offer>
HWY_INLINE void OfferNeighbours(const BandSlice& s, size_t step, const Nearest& best,
                                Offer&& offer) {
  VF apart = F(1.0f);
  const size_t end = (s.window + 1) * step;
  for (size_t off = step; off < end; off += 2 * step) {
    const VF apart2 = hn::Mul(apart, apart);
    if (best.beats(apart2)) return;
    offer(apart2, off);
    apart = hn::Add(apart, F(1.0f));
    offer(hn::Mul(apart, apart), off + step);
    apart = hn::Add(apart, F(1.0f));
  }
}

// The nearest end on each node's own ray.
HWY_INLINE void FindOnRays(const BandSlice& s, size_t row) {
  BandScratch& to = *s.scratch;
  const size_t pitch = s.cols + 2 * s.margin;
  for (size_t c = 0; c < s.cols; c++) {
    const size_t ray = row * s.cols + c, at = row * pitch + s.margin + c;
    if (!s.near(s.ray_ends[ray]) ||
        !(s.away + s.row_ends_away[row] + s.col_ends_away[c] < s.reach2)) {
      // No ends here. Also clears the results of an earlier slice.
      if (to.seeded[ray]) std::fill_n(to.seed_distance2[at].lane, kRow, s.too_far);
      to.seeded[ray] = 0;
      continue;
    }
    to.seeded[ray] = 1;
    const RayItems rays = s.rays[ray];
    VF min2 = F(s.too_far);
    unsigned any = 0;
    for (size_t g = 0; g < kGroups; g++) {
      Nearest best{F(s.too_far), hn::Set(DI(), -1)};
      for (uint32_t l = rays.first; l < rays.first + rays.count; l++) {
        const VF off = s.layers ? hn::Sub(Lanes(s.layers[l].depth, g), F(s.depth))
                                : hn::Sub(F(s.ends[l].place.x()), LanesFrom(s.depth, g));
        best.offer(hn::Mul(off, off),
                   s.layers ? Lanes(s.layers[l].end, g) : hn::Set(DI(), static_cast<int32_t>(l)));
      }
      Store(best.distance2, to.seed_distance2[at], g);
      Store(best.end, to.seed_end[at], g);
      min2 = hn::Min(min2, best.distance2);
      any |= Bits(hn::Lt(best.distance2, F(s.too_far))) << (g * kLanes);
    }
    const size_t nodes = NodesWithin(s, min2);
    if (nodes == 0) continue;
    // Number of blocks on each side that these ends may serve.
    size_t below = nodes - 1, above = nodes - 1;
    if (s.step == 1) {
      const auto blocks = [&](int lanes_before) {
        return (nodes + kRow - 2 - static_cast<size_t>(lanes_before)) / kRow;
      };
      below = blocks(std::countr_zero(any));
      above = blocks(std::countl_zero(any) - (32 - static_cast<int>(kRow)));
    }
    uint8_t* const near = to.seeds_near.data() + row * s.cols;
    const size_t end = std::min(s.cols, c + above + 1);
    for (size_t i = c < below ? 0 : c - below; i < end; i++) near[i] = 1;
  }
}

// The nearest end on the rays of each node's row.
HWY_INLINE void FindInRow(const BandSlice& s, size_t row) {
  BandScratch& to = *s.scratch;
  const size_t pitch = s.cols + 2 * s.margin;
  for (size_t c = 0; c < s.cols; c++) {
    if (!to.seeds_near[row * s.cols + c] ||
        !(s.away + s.row_ends_away[row] + s.col_away[c] < s.reach2))
      continue;
    const size_t seed = row * pitch + s.margin + c, at = (row + s.window + 1) * s.cols + c;
    VF min2 = F(s.too_far);
    for (size_t g = 0; g < kGroups; g++) {
      Nearest best{Lanes(to.seed_distance2[seed], g), Lanes(to.seed_end[seed], g)};
      const float* const distance2 = to.seed_distance2[seed].lane + g * kLanes;
      const int32_t* const end = to.seed_end[seed].lane + g * kLanes;
      OfferNeighbours(s, s.step, best, [&](VF apart2, size_t off) {
        best.offer(Nearest{hn::LoadU(DF(), distance2 - off), hn::LoadU(DI(), end - off)},
                   Nearest{hn::LoadU(DF(), distance2 + off), hn::LoadU(DI(), end + off)}, apart2);
      });
      Store(best.distance2, to.row_distance2[at], g);
      Store(best.end, to.row_end[at], g);
      min2 = hn::Min(min2, best.distance2);
    }
    to.rows_near[row * s.cols + c] = static_cast<uint8_t>(NodesWithin(s, min2));
  }
}

// The nearest end on the slice's rays. Writes it to the band if it is nearer than the band's.
HWY_INLINE void FindInSlice(const BandSlice& s, size_t row) {
  BandScratch& from = *s.scratch;
  for (size_t c = 0; c < s.cols; c++) {
    if (!from.rows_near[row * s.cols + c] || !(s.away + s.row_away[row] + s.col_away[c] < s.reach2))
      continue;
    const size_t at = (row + s.window + 1) * s.cols + c;
    const size_t block = s.first + row * s.row_step + c * s.col_step;
    if (s.wanted && !s.wanted[block]) continue;
    const bool known = s.known[block] != 0;
    unsigned found = 0;
    FloatRow distance2;
    IndexRow nearest;
    for (size_t g = 0; g < kGroups; g++) {
      Nearest best{known ? Lanes(s.distance2[block], g) : F(s.too_far),
                   known ? Lanes(s.nearest[block], g) : hn::Set(DI(), -1)};
      const float* const of = from.row_distance2[at].lane + g * kLanes;
      const int32_t* const end = from.row_end[at].lane + g * kLanes;
      best.offer(hn::Load(DF(), of), hn::Load(DI(), end));
      OfferNeighbours(s, s.cols * kRow, best, [&](VF apart2, size_t off) {
        best.offer(hn::Add(hn::Load(DF(), of - off), apart2), hn::Load(DI(), end - off));
        best.offer(hn::Add(hn::Load(DF(), of + off), apart2), hn::Load(DI(), end + off));
      });
      Store(best.distance2, distance2, g);
      Store(best.end, nearest, g);
      found |= Bits(hn::Lt(best.distance2, F(s.too_far))) << (g * kLanes);
    }
    if (!found) continue;
    s.distance2[block] = distance2;
    s.nearest[block] = nearest;
    s.known[block] = static_cast<uint16_t>(found);
  }
}

void SearchSlice(const BandSlice& s) {
  BandScratch& scratch = *s.scratch;
  std::fill_n(scratch.seeds_near.begin(), s.rows * s.cols, uint8_t{0});
  std::fill_n(scratch.rows_near.begin(), s.rows * s.cols, uint8_t{0});
  size_t first = s.rows, end = 0;  // rows with ends
  for (size_t row = 0; row < s.rows; row++)
    if (s.near(s.row_ends[row])) {
      FindOnRays(s, row);
      FindInRow(s, row);
      first = std::min(first, row);
      end = row + 1;
    }
  if (first >= end) return;
  const size_t low = first - std::min(first, s.window), high = std::min(s.rows, end + s.window);
  // rows_near decreases by one from a row to the adjacent rows.
  const auto pass_on = [cols = s.cols](const uint8_t* from, uint8_t* to) {
    for (size_t c = 0; c < cols; c++)
      to[c] = std::max(to[c], static_cast<uint8_t>(from[c] - (from[c] > 0)));
  };
  uint8_t* const near = scratch.rows_near.data();
  for (size_t r = first + 1; r < high; r++) pass_on(near + (r - 1) * s.cols, near + r * s.cols);
  for (size_t r = end - 1; r-- > low;) pass_on(near + (r + 1) * s.cols, near + r * s.cols);
  for (size_t row = low; row < high; row++) FindInSlice(s, row);
  std::fill_n(scratch.row_distance2[(first + s.window + 1) * s.cols].lane,
              (end - first) * s.cols * kRow, s.too_far);
}

// Sets the nodes to -width (inside) or width (outside).
void ComputeSides(const BandPlane& p) {
  const VF z = F(p.z), outside = F(p.width), inside = F(-p.width);
  for (size_t row = 0; row < p.rows; row++) {
    const size_t first = p.computed ? p.computed[row].low / kRow : 0,
                 end = p.computed ? (p.computed[row].high + kRow - 1) / kRow : p.blocks;
    for (size_t b = first; b < end; b++) {
      if (!(p.away + p.row_away[row] + p.block_away[b] < p.reach2)) continue;
      if (p.wanted && !p.wanted[row * p.blocks + b]) continue;
      const RayItems rays = p.rays[row * p.blocks + b];
      float* const phi = p.phi + row * p.nx + b * kRow;
      for (size_t g = 0; g < kGroups; g++) {
        VF side = outside;
        for (uint32_t l = rays.first; l < rays.first + rays.count; l++)
          side = hn::IfThenElse(
              hn::And(hn::Le(Lanes(p.spans[l].in, g), z), hn::Lt(z, Lanes(p.spans[l].out, g))),
              inside, side);
        hn::Store(side, DF(), phi + g * kLanes);
      }
    }
  }
}

// phi of nodes whose nearest end is known.
void Measure(const MeasuredBlocks& of) {
  const DF d;
  FloatRow place[3], normal[3];  // by axis
  for (const NodeBlock* block = of.blocks; block < of.blocks + of.count; block++) {
    const IndexRow& nearest = of.nearest[block->place / kRow];
    // A node without an end uses the first end. Its result is dropped below.
    for (size_t n = 0; n < kRow; n++) {
      const SurfaceEnd& end = of.ends[std::max(nearest.lane[n], 0)];
      for (int axis = 0; axis < 3; axis++) {
        place[axis].lane[n] = end.place[axis];
        normal[axis].lane[n] = end.normal[axis];
      }
    }
    const VF y = F(static_cast<float>(block->j) + 0.5f), z = F(static_cast<float>(block->k) + 0.5f);
    float* const phi = of.phi + block->place;
    for (size_t g = 0; g < kGroups; g++) {
      const VF dx = hn::Sub(LanesFrom(static_cast<float>(block->i) + 0.5f, g), Lanes(place[0], g)),
               dy = hn::Sub(y, Lanes(place[1], g)), dz = hn::Sub(z, Lanes(place[2], g));
      const VF along = hn::Abs(
          hn::Add(hn::Add(hn::Mul(dx, Lanes(normal[0], g)), hn::Mul(dy, Lanes(normal[1], g))),
                  hn::Mul(dz, Lanes(normal[2], g))));
      const VF distance2 = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const VF beyond = hn::Sqrt(hn::Max(hn::Zero(d), hn::Sub(distance2, F(1.0f))));
      const VF size = hn::Min(F(of.width), hn::Max(along, beyond)),
               was = hn::Load(d, phi + g * kLanes);
      const VF is =
          hn::IfThenElse(hn::Lt(was, hn::Zero(d)), hn::Neg(hn::Max(size, F(kMinDepth))), size);
      const MF known = FromBits(block->nodes >> (g * kLanes) & kGroupMask);
      hn::Store(hn::IfThenElse(known, is, was), d, phi + g * kLanes);
    }
  }
}

double AddedVolume(const ChangedBlocks& of) {
  const DF d;
  const VF zero = hn::Zero(d), one = F(1), half = F(0.5f);
  // The share of a node's cell that is inside.
  const auto share = [&](VF phi)
                         HWY_ATTR { return hn::Min(hn::Max(hn::Sub(half, phi), zero), one); };
  double volume = 0;
  for (const NodeBlock* block = of.blocks; block < of.blocks + of.count; block++) {
    // Outside the lattice there is no material.
    if (block->j < of.low[1] || block->j >= of.high[1] || block->k < of.low[2] ||
        block->k >= of.high[2])
      continue;
    for (size_t g = 0; g < kGroups; g++) {
      const unsigned nodes = block->nodes >> (g * kLanes) & kGroupMask;
      if (!nodes) continue;
      const VF i = LanesFrom(static_cast<float>(block->i), g);
      const MF there = hn::And(hn::Ge(i, F(static_cast<float>(of.low[0]))),
                               hn::Lt(i, F(static_cast<float>(of.high[0]))));
      const VF was = hn::Load(d, of.phi + block->place + g * kLanes),
               is = hn::Load(d, of.after + block->place + g * kLanes);
      const VF more =
          hn::IfThenElseZero(hn::And(there, FromBits(nodes)), hn::Sub(share(is), share(was)));
      if (hn::AllFalse(d, hn::Ne(more, zero))) continue;
      // Adds lane by lane, so that the result does not depend on the vector unit.
      float lanes[kLanes];
      hn::StoreU(more, d, lanes);
      for (const float lane : lanes) volume += double{lane};
    }
  }
  return volume;
}

void WeighCollar(const CollarBlocks& of) {
  const DF d;
  const VF zero = hn::Zero(d), one = F(1), ramp = F(static_cast<float>(of.ramp)),
           radius2 = F(static_cast<float>(of.radius * of.radius));
  const auto from_centre = [&](int node, int axis) {
    return static_cast<float>(node + 0.5 - of.centre[axis]);
  };
  for (size_t b = 0; b < of.count; b++) {
    NodeBlock& block = of.blocks[b];
    const float y = from_centre(block.j, 1), z = from_centre(block.k, 2);
    const VF across2 = F(y * y + z * z);
    unsigned rises = 0;
    float areas[kRow];
    for (size_t g = 0; g < kGroups; g++) {
      const size_t node = block.place + g * kLanes;
      const VF x = LanesFrom(from_centre(block.i, 0), g),
               distance2 = hn::Div(hn::Add(hn::Mul(x, x), across2), radius2),
               inner = hn::Max(zero, hn::Sub(one, distance2));
      const VF off = hn::Div(hn::Load(d, of.path_phi + node), ramp),
               free = hn::Min(one, hn::Max(zero, off));
      const MF touched = FromBits(block.nodes >> (g * kLanes) & kGroupMask);
      const VF weight = hn::IfThenElseZero(touched, hn::Mul(hn::Mul(inner, inner), free));
      rises |= Bits(hn::Gt(weight, zero)) << (g * kLanes);
      Store(weight, of.weights[b], g);
      // The shares of the nodes along a normal add up to 1.
      const VF share = hn::Max(zero, hn::Sub(one, hn::Abs(hn::Load(d, of.phi + node))));
      hn::StoreU(hn::Mul(weight, share), d, areas + g * kLanes);
    }
    block.nodes = static_cast<uint16_t>(rises);
    of.areas[b] = 0;
    for (const float area : areas) of.areas[b] += double{area};
  }
}

// Of 16 nodes, those with |phi| < depth.
uint32_t NodesWithinDepth(const float* phi, float depth) {
  uint32_t nodes = 0;
  for (size_t g = 0; g < kGroups; g++)
    nodes |= Bits(hn::Lt(hn::Abs(hn::Load(DF(), phi + g * kLanes)), F(depth))) << (g * kLanes);
  return nodes;
}

uint32_t NodesThatDiffer(const float* one, const float* two) {
  const DF d;
  uint32_t nodes = 0;
  for (size_t g = 0; g < kGroups; g++)
    nodes |= Bits(hn::Ne(hn::Load(d, one + g * kLanes), hn::Load(d, two + g * kLanes)))
             << (g * kLanes);
  return nodes;
}

void SumRows(const float* const* low, const float* const* high, const std::vector<float>& kernel,
             size_t count, float* to) {
  const DF d;
  const auto sum_at = [&](size_t i) {
    VF sum = hn::Mul(F(kernel[0]), hn::LoadU(d, low[0] + i));
    for (size_t m = 1; m < kernel.size(); m++)
      sum = hn::Add(
          sum, hn::Mul(F(kernel[m]), hn::Add(hn::LoadU(d, low[m] + i), hn::LoadU(d, high[m] + i))));
    hn::StoreU(sum, d, to + i);
  };
  for (size_t i = 0; i + kLanes < count; i += kLanes) sum_at(i);
  sum_at(count - kLanes);  // may repeat some of the nodes above
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {

HWY_EXPORT(SearchSlice);
HWY_EXPORT(ComputeSides);
HWY_EXPORT(Measure);
HWY_EXPORT(AddedVolume);
HWY_EXPORT(WeighCollar);
HWY_EXPORT(NodesWithinDepth);
HWY_EXPORT(NodesThatDiffer);
HWY_EXPORT(SumRows);

BandKernels band_kernels() {
  choose_vector_unit();
  return {HWY_DYNAMIC_DISPATCH(SearchSlice),     HWY_DYNAMIC_DISPATCH(ComputeSides),
          HWY_DYNAMIC_DISPATCH(Measure),         HWY_DYNAMIC_DISPATCH(AddedVolume),
          HWY_DYNAMIC_DISPATCH(WeighCollar),     HWY_DYNAMIC_DISPATCH(NodesWithinDepth),
          HWY_DYNAMIC_DISPATCH(NodesThatDiffer), HWY_DYNAMIC_DISPATCH(SumRows)};
}

}  // namespace kibori
#endif
