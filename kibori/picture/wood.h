// SPDX-License-Identifier: MIT
// Wood as a solid texture, the same as in web/src/wood.ts: what is changed here is changed there.
// Internal to `picture`.
#pragma once

#include <kibori/geometry/vec.h>

namespace kibori {

// A log: where its pith runs, how wide its rings are.
struct Log {
  Vec3 pith;        // a point on it [mm]
  Vec3 along;       // unit, the way the tree grew
  double ring = 2;  // mean width of a year's ring [mm]
};

struct WoodPoint {
  double dark;   // 0: early wood, light; 1: late wood, dark
  double gloss;  // 0 ... 1
};

WoodPoint wood_at(const Log& log, const Vec3& point);

}  // namespace kibori
