// SPDX-License-Identifier: MIT
// Wood as a solid texture. web/src/view/wood.ts has the same texture: change both files together.
// Internal to `picture`.
#pragma once

#include <kibori/geometry/wood.h>

namespace kibori {

struct WoodPoint {
  double dark;   // from 0 (light early wood) to 1 (dark late wood)
  double gloss;  // from 0 to 1
};

WoodPoint wood_at(const Log& log, const Vec3& point);

}  // namespace kibori
