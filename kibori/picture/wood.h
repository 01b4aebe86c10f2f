// SPDX-License-Identifier: MIT
// Wood as a solid texture. web/src/view/wood.ts has the same texture: change both. Internal to
// `picture`.
#pragma once

#include <kibori/geometry/wood.h>

namespace kibori {

struct WoodPoint {
  double dark;   // 0: early wood, light; 1: late wood, dark
  double gloss;  // 0 ... 1
};

WoodPoint wood_at(const Log& log, const Vec3& point);

}  // namespace kibori
