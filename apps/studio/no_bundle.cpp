// SPDX-License-Identifier: MIT
// In place of bundle.cpp, where there was nothing to build the page with.
#include "apps/studio/bundle.h"

namespace kibori::studio {

std::span<const BundledFile> bundle() { return {}; }

}  // namespace kibori::studio
