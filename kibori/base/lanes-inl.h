// SPDX-License-Identifier: MIT
// Vector helpers that the kernels share. A source includes this file once per Highway target. A
// target is one instruction set, for example AVX2.
//
// A row always has 16 lanes. The lanes that one vector holds are a group: a row is one group of
// AVX-512, two of AVX2, or four of SSE. Every operation here is IEEE +, -, *, /, sqrt or integer
// work, for each lane separately. Therefore, a lane's bits do not depend on the target. MulAdd is
// not used, because it rounds once on some targets and twice on others.

#if defined(KIBORI_BASE_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KIBORI_BASE_LANES_INL_H_
#undef KIBORI_BASE_LANES_INL_H_
#else
#define KIBORI_BASE_LANES_INL_H_
#endif

#include <cstdint>

#include <hwy/highway.h>

#include <kibori/base/tolerances.h>

HWY_BEFORE_NAMESPACE();
namespace kibori {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

inline constexpr size_t kRow = 16;
using DF = hn::CappedTag<float, kRow>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;
using MF = hn::Mask<DF>;
inline constexpr size_t kLanes = hn::MaxLanes(DF());
inline constexpr size_t kGroups = kRow / kLanes;
inline constexpr unsigned kGroupMask = (1u << kLanes) - 1;

HWY_INLINE VF F(float x) { return hn::Set(DF(), x); }

// Returns base + lane index for the lanes of a group. Each sum is rounded once. With two additions,
// a sum would depend on the target: (base + 8) + 3 can differ from base + 11 in the last bit.
HWY_INLINE VF LanesFrom(float base, size_t group) {
  return hn::Add(F(base), hn::Iota(DF(), static_cast<float>(group * kLanes)));
}

// Converts a mask of lanes to bits (lane 0 is the lowest bit), and back.
HWY_INLINE unsigned Bits(MF m) {
  uint16_t bits = 0;
  hn::StoreMaskBits(DF(), m, reinterpret_cast<uint8_t*>(&bits));
  return kLanes == 16 ? bits : bits & kGroupMask;
}
HWY_INLINE MF FromBits(unsigned bits) {
  alignas(64)
      const uint8_t bytes[8] = {static_cast<uint8_t>(bits), static_cast<uint8_t>(bits >> 8)};
  return hn::LoadMaskBits(DF(), bytes);
}

// Returns 1 / sqrt(x) for x > 0, with a relative error of about 5e-6. An integer operation gives a
// first guess, and two Newton steps improve it. Therefore, the result is the same on every target.
HWY_INLINE VF RoughRsqrt(VF x) {
  const DF d;
  const DI di;
  const VI guess = hn::Sub(hn::Set(di, 0x5f375a86), hn::ShiftRight<1>(hn::BitCast(di, x)));
  VF y = hn::BitCast(d, guess);
  const VF half = hn::Mul(x, F(0.5f));
  y = hn::Mul(y, hn::Sub(F(1.5f), hn::Mul(hn::Mul(half, y), y)));
  return hn::Mul(y, hn::Sub(F(1.5f), hn::Mul(hn::Mul(half, y), y)));
}

// Factor from a component of a unit normal to its number in normal_code.h. `flip` reverses the
// normal.
HWY_INLINE float NormalScale(bool flip) { return flip ? -32767.0f : 32767.0f; }

// Returns the code (normal_code.h) of a vector, from its u and v components. `scale` is NormalScale
// divided by the vector's length.
HWY_INLINE VU EncodeScaled(VF u, VF v, VF scale) {
  const DU du;
  // The addition of 1.5 x 2^23 rounds to an integer, and puts it into the low bits of the mantissa.
  const VF e = hn::Add(hn::Mul(u, scale), F(12582912.0f)),
           f = hn::Add(hn::Mul(v, scale), F(12582912.0f));
  return hn::Or(hn::And(hn::BitCast(du, e), hn::Set(du, 0xffffu)),
                hn::ShiftLeft<16>(hn::BitCast(du, f)));
}

// Returns the code of a vector of any length > 0. `scale` is NormalScale.
HWY_INLINE VU EncodeNormal(VF u, VF v, VF depth, float scale) {
  const VF length2 =
      hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), hn::Max(hn::Mul(depth, depth), F(1e-30f)));
  // RoughRsqrt may be too large by 5e-6. The factor keeps the components within 16 bits.
  return EncodeScaled(u, v, hn::Mul(RoughRsqrt(length2), F(scale * 0.99999f)));
}

}  // namespace HWY_NAMESPACE
}  // namespace kibori
HWY_AFTER_NAMESPACE();

#endif
