// SPDX-License-Identifier: MIT
#include <kibori/edit/grain.h>

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kibori/edit/grain.cpp"
#include <hwy/foreach_target.h>
#include <kibori/base/lanes-inl.h>

#ifndef KIBORI_GRAIN_SHARED
#define KIBORI_GRAIN_SHARED
namespace kibori {

// Length of a part of a piece [rings], and the maximum number of parts. Near the pith, the distance
// between rings along a ray changes quickly. With longer parts, the rings would be at wrong places.
inline constexpr float kPart = 0.25f;
inline constexpr float kMaxParts = 128;

}  // namespace kibori
#endif

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {

// For a shorter piece [rings], the value at its middle is used. A difference of two integrals would
// be mostly rounding error.
constexpr float kShort = 4e-3f;
// Avoids 0 / 0 where a ray runs along the pith.
constexpr float kNoDistance = 1e-12f;

HWY_INLINE VF Clamp(VF x, VF low, VF high) { return hn::Min(hn::Max(x, low), high); }
HWY_INLINE VF Mix(VF a, VF b, VF share) { return hn::Add(a, hn::Mul(share, hn::Sub(b, a))); }

// Distance of a point from the pith [rings], and its slope per lattice unit along the ray.
struct Rings {
  VF at, slope;
};

HWY_INLINE Rings RingsAt(const Grain::View& k, VF u, VF v, VF t) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d), one = F(1.0f);
  // The wave: interpolate along u and v first, because its slope along the ray is also needed.
  VI from = hn::Zero(di);
  VF part[3];
  const VF place[3] = {u, v, t};
  for (int i = 0; i < 3; i++) {
    const VF x = hn::Mul(place[i], F(k.per_step));
    const VI cell = hn::ConvertTo(di, Clamp(x, zero, F(k.last[i])));
    part[i] = Clamp(hn::Sub(x, hn::ConvertTo(d, cell)), zero, one);
    from = hn::Add(from, hn::Mul(cell, hn::Set(di, k.stride[i])));
  }
  const auto line = [&](const float* p) HWY_ATTR {
    return Mix(hn::GatherIndex(d, p, from), hn::GatherIndex(d, p + k.stride[0], from), part[0]);
  };
  const auto face = [&](const float* p)
                        HWY_ATTR { return Mix(line(p), line(p + k.stride[1]), part[1]); };
  const VF near = face(k.waves), far = face(k.waves + k.stride[2]);
  // The distance from the pith (rings_at of geometry/wood.h), and its derivative.
  VF across[3] = {hn::Sub(u, F(k.pith[0])), hn::Sub(v, F(k.pith[1])), hn::Sub(t, F(k.pith[2]))};
  VF along = zero, square = zero;
  for (int i = 0; i < 3; i++) along = hn::Add(along, hn::Mul(across[i], F(k.along[i])));
  for (int i = 0; i < 3; i++) {
    across[i] = hn::Sub(across[i], hn::Mul(along, F(k.along[i])));
    square = hn::Add(square, hn::Mul(across[i], across[i]));
  }
  const VF distance = hn::Sqrt(square);
  const VF out = hn::Div(across[2], hn::Max(distance, F(kNoDistance)));
  return {hn::Add(hn::Mul(distance, F(k.per_ring)), Mix(near, far, part[2])),
          hn::Add(hn::Mul(out, F(k.per_ring)), hn::Mul(hn::Sub(far, near), F(k.per_step)))};
}

HWY_INLINE VF EarlyWood(const Grain::View& k, VF year) {
  const DI di;
  const VF known = hn::Sub(Clamp(year, F(k.first_year), F(k.last_year)), F(k.first_year));
  return hn::GatherIndex(DF(), k.early, hn::ConvertTo(di, known));
}

// The integral of t^2 (3 - 2 t) (1 - t) from 0 to t.
HWY_INLINE VF Falling(VF t) {
  const VF t3 = hn::Mul(t, hn::Mul(t, t));
  return hn::Mul(t3, hn::Add(F(1.0f), hn::Mul(t, hn::Sub(hn::Mul(t, F(0.4f)), F(1.25f)))));
}

// The integral of late_wood over the first `part` of a ring whose early wood is `early`.
HWY_INLINE VF LateUntil(VF early, VF part) {
  constexpr float kEdge = static_cast<float>(kRingEdge);
  const VF zero = hn::Zero(DF()), one = F(1.0f);
  const VF size = hn::Sub(one, early), per_size = hn::Div(one, size);
  const VF t = hn::Mul(hn::Max(hn::Sub(part, early), zero), per_size);
  // The t at which late_wood begins to fall (kRingEdge).
  const VF bend = hn::Sub(one, hn::Mul(per_size, F(kEdge)));
  const VF rising = hn::Min(t, bend);
  const VF rise = hn::Mul(hn::Mul(hn::Mul(size, hn::Mul(rising, rising)), rising),
                          hn::Sub(one, hn::Mul(rising, F(0.5f))));
  const VF fall = hn::Mul(hn::Mul(hn::Mul(size, size), F(1.0f / kEdge)),
                          hn::Sub(Falling(hn::Max(t, bend)), Falling(bend)));
  return hn::Add(rise, fall);
}

// late_wood of geometry/wood.h.
HWY_INLINE VF LateAt(VF early, VF part) {
  const VF zero = hn::Zero(DF()), one = F(1.0f);
  const VF t = Clamp(hn::Div(hn::Sub(part, early), hn::Sub(one, early)), zero, one);
  const VF edge =
      Clamp(hn::Mul(hn::Sub(one, part), F(1.0f / static_cast<float>(kRingEdge))), zero, one);
  return hn::Mul(hn::Mul(hn::Mul(t, t), hn::Sub(F(3.0f), hn::Add(t, t))), edge);
}

// The mean of late_wood over `length` rings, at most one, about the middle `at`.
HWY_INLINE VF MeanLate(const Grain::View& k, VF at, VF length) {
  const DF d;
  const MF is_short = hn::Lt(length, F(kShort));
  const VF half = hn::IfThenZeroElse(is_short, hn::Mul(length, F(0.5f)));
  const VF from = hn::Sub(at, half), to = hn::Add(at, half);
  const VF year = hn::Floor(to), part = hn::Sub(to, year), early = EarlyWood(k, year);
  VF mean = LateAt(early, part);  // for short pieces
  if (!hn::AllTrue(d, is_short)) {
    const VF before = hn::Floor(from);
    const MF over = hn::Lt(before, year);  // the piece contains the end of a year
    const VF early_before = hn::IfThenElse(over, EarlyWood(k, before), early);
    VF sum = hn::Sub(LateUntil(early, part), LateUntil(early_before, hn::Sub(from, before)));
    if (!hn::AllFalse(d, over))
      sum = hn::Add(sum, hn::IfThenElseZero(over, LateUntil(early_before, F(1.0f))));
    mean =
        hn::IfThenElse(is_short, mean, hn::Div(sum, hn::Max(hn::Sub(to, from), F(0.5f * kShort))));
  }
  return mean;
}

void LateWoodOf(const Grain::View& k, float u_first, float v_at, const float* lo, const float* hi,
                size_t count, float* means) {
  const DF d;
  for (size_t g = 0; g * kLanes < count; g++) {
    const VF u = LanesFrom(u_first, g), v = F(v_at);
    const VF begin = hn::LoadU(d, lo + g * kLanes),
             length = hn::Sub(hn::LoadU(d, hi + g * kLanes), begin);
    const VF parts = Clamp(hn::Ceil(hn::Mul(length, F(k.per_ring / kPart))), F(1.0f), F(kMaxParts));
    const VF part = hn::Div(length, parts);
    VF sum = hn::Zero(d), number = hn::Zero(d);
    for (MF left = hn::Lt(number, parts); !hn::AllFalse(d, left); left = hn::Lt(number, parts)) {
      const VF t = hn::Add(begin, hn::Mul(part, hn::Add(number, F(0.5f))));
      const Rings rings = RingsAt(k, u, v, t);
      const VF seen = hn::Min(hn::Abs(hn::Mul(part, rings.slope)), F(1.0f));
      sum = hn::Add(sum, hn::IfThenElseZero(left, MeanLate(k, rings.at, seen)));
      number = hn::Add(number, F(1.0f));
    }
    hn::StoreU(hn::Div(sum, parts), d, means + g * kLanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kibori {
HWY_EXPORT(LateWoodOf);

namespace {

// Nodes of the coarse grid along the lattice's longest side. By default 26 rings fit there, and a
// wave is at least five rings long. So a wave has twelve nodes.
constexpr int kNodes = 64;
// For a given ring width: the grid's step [rings], about the same as above, and the maximum number
// of nodes. At this maximum the step is longer, so that short waves are smoothed.
constexpr double kStepRings = 0.41, kMaxNodes = 1e6;
// Upper bound of a wave's displacement [rings].
constexpr int kMaxWave = 4;
// Maximum number of years with their own early wood. Later years use the last value.
constexpr int kMaxYears = 4096;

}  // namespace

std::shared_ptr<const Grain> Grain::of(const Lattice& lattice,
                                       const std::vector<Material>& materials) {
  if (std::none_of(materials.begin(), materials.end(), has_grain)) return nullptr;
  return std::make_shared<const Grain>(log_of(lattice.to_mm(lattice.base()), log_cut_of(materials)),
                                       lattice, materials);
}

Grain::Grain(const Log& log, const Lattice& lattice, const std::vector<Material>& materials)
    : log_(log) {
  log_.pith = lattice.to_lattice(log.pith).units;
  log_.ring = log.ring / lattice.pitch_mm;
  kinds_.reserve(materials.size() + 1);
  for (const Material& m : materials) {
    // The chip law (haptics/chip.h) itself includes the effect of the direction.
    const bool by_direction = !has_chip_law(m) && has_direction(m) && m.u > 0;
    kinds_.push_back({by_direction || m.ring != 0, by_direction ? m.u_along / m.u : 1, m.ring});
  }
  if (kinds_.empty()) kinds_.emplace_back();
  double step = static_cast<double>(lattice.nodes.maxCoeff()) / kNodes;  // [lattice units]
  if (log_cut_of(materials).ring_mm > 0) {
    const double volume = lattice.nodes.cast<double>().prod();
    step = std::max(kStepRings * log_.ring, std::cbrt(volume / kMaxNodes));
  }
  Index3 count;
  for (int i = 0; i < 3; i++) count[i] = static_cast<int>(std::ceil(lattice.nodes[i] / step)) + 2;
  waves_.reserve(static_cast<size_t>(count.prod()));
  for (int z = 0; z < count[2]; z++)
    for (int y = 0; y < count[1]; y++)
      for (int x = 0; x < count[0]; x++)
        waves_.push_back(static_cast<float>(ring_wave(log_, step * Vec3(x, y, z))));
  double farthest = 0;
  for (int corner = 0; corner < 8; corner++) {
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < 3; i++)
      if ((corner >> i) & 1) p[i] = lattice.nodes[i];
    farthest = std::max(farthest, (p - log_.pith).norm());
  }
  const int years =
      static_cast<int>(std::min<double>(kMaxYears, farthest / log_.ring)) + 2 * kMaxWave;
  for (int year = -kMaxWave; year < years; year++)
    early_.push_back(static_cast<float>(early_wood(year)));
  const Index3 stride(1, count[0], count[0] * count[1]);
  for (const Axis axis : kAxes) {
    View& k = views_[static_cast<size_t>(axis)];
    const int order[3] = {u_index(axis), v_index(axis), depth_index(axis)};
    for (int i = 0; i < 3; i++) {
      k.pith[i] = static_cast<float>(log_.pith[order[i]]);
      k.along[i] = static_cast<float>(log_.along[order[i]]);
      k.last[i] = static_cast<float>(count[order[i]] - 2);
      k.stride[i] = stride[order[i]];
    }
    k.per_ring = static_cast<float>(1 / log_.ring);
    k.per_step = static_cast<float>(1 / step);
    k.waves = waves_.data();
    k.early = early_.data();
    k.first_year = -kMaxWave;
    k.last_year = static_cast<float>(years - 1);
  }
}

void Grain::late_wood_of(Axis axis, float u, float v, const float* lo, const float* hi,
                         size_t count, float* means) const {
  HWY_DYNAMIC_DISPATCH(LateWoodOf)
  (views_[static_cast<size_t>(axis)], u, v, lo, hi, count, means);
}

}  // namespace kibori
#endif
