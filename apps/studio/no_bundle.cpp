// SPDX-License-Identifier: MIT
// Replaces bundle.cpp if the tools that build the page are missing.
#include "apps/studio/bundle.h"

namespace kibori::studio {

std::span<const BundledFile> bundle() { return {}; }

}  // namespace kibori::studio
