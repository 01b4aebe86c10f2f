// SPDX-License-Identifier: MIT
// Small models at a pitch of 1 mm, and measurements for tests of reshaping.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/edit.h>
#include <kibori/reshape/node_band.h>
#include <kibori/solid/tool.h>

namespace kibori::test {

inline Lattice cube(int nodes) {
  Lattice lattice;
  lattice.nodes = Index3::Constant(nodes);
  lattice.pitch_mm = 1;
  return lattice;
}

inline void add(TriDexel& model, const Solid& solid, uint8_t material = 0) {
  Removed added;
  deposit(model, solid, material, {}, added);
}

// A tool that does not move.
inline SweptTool tool_at(const Tool& tool, const Pose& pose, const Lattice& lattice) {
  return SweptTool(tool, pose, Vec3::Zero(), lattice);
}

// Calls f(place, normal) for all ends of all fields that are inside the lattice.
template <class F>
void for_ends(const TriDexel& model, F&& f) {
  NodeBand band;
  band.read(model, {Index3::Zero(), model.lattice().nodes}, 2);
  for (const SurfaceEnd& end : band.ends())
    if ((end.place.array() > 0.01f).all() &&
        (end.place.array() < model.lattice().nodes.cast<float>() - 0.01f).all())
      f(Vec3(end.place.cast<double>()), Vec3(end.normal.cast<double>()));
}

// Number of spans that are outside the bounds of their plane. An edit may overlook them.
inline int outside_bounds(const FieldSnapshot& field) {
  int count = 0;
  for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
    for (int tu = field.tu_begin(); tu < field.tu_end(); tu++)
      for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next)
        for (int slot = 0; slot < kTileRays; slot++)
          count += !p->empty_at(slot) && (p->in[slot] < p->near || p->out[slot] > p->far);
  return count;
}

// Number of nodes that are inside in one field and outside in another, both by more than rounding.
// Also checks that all spans are within the bounds of their planes.
inline int disagreeing(const TriDexel& model) {
  constexpr float kRounding = 1e-4f;
  const Index3 low = model.lattice().low(), n = model.lattice().high() - low;
  // one bit per field
  std::vector<uint8_t> surely(static_cast<size_t>(n.prod()), 0), maybe(surely);
  for (const Axis axis : kAxes) {
    const auto bit = static_cast<uint8_t>(1 << static_cast<int>(axis));
    const FieldSnapshot& field = model.field(axis).view();
    EXPECT_EQ(outside_bounds(field), 0);
    for (int v = field.v_begin(); v < field.v_end(); v++)
      for (int u = field.u_begin(); u < field.u_end(); u++)
        field.for_spans(u, v, [&](const Span& span) {
          EXPECT_LT(span.in, span.out);
          for (int k = field.depth_begin(); k < field.depth_end(); k++) {
            const float depth = static_cast<float>(k) + 0.5f;
            Index3 at;
            at[u_index(axis)] = u, at[v_index(axis)] = v, at[depth_index(axis)] = k;
            at -= low;
            const auto node = static_cast<size_t>((at[2] * n[1] + at[1]) * n[0] + at[0]);
            if (depth >= span.in - kRounding && depth < span.out + kRounding) maybe[node] |= bit;
            if (depth >= span.in + kRounding && depth < span.out - kRounding) surely[node] |= bit;
          }
        });
  }
  int wrong = 0;
  for (size_t i = 0; i < surely.size(); i++) wrong += surely[i] != 0 && maybe[i] != 7;
  return wrong;
}

}  // namespace kibori::test
