// SPDX-License-Identifier: MIT
// A material without grain, for tests.
#pragma once

#include <kibori/geometry/material.h>

namespace kibori::test {

// kf: N per point; u: N/mm^2; c: N s/mm^3; yield_n: N.
inline Material plain_material(const char* name, double kf, double u, double c = 0,
                               double yield_n = 0) {
  Material m;
  m.name = name;
  m.kf = kf;
  m.u = u;
  m.c = c;
  m.yield_n = yield_n;
  return m;
}

}  // namespace kibori::test
