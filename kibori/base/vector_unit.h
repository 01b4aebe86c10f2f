// SPDX-License-Identifier: MIT
#pragma once

#include <hwy/targets.h>

namespace kibori {

// Call this before keeping the address that HWY_DYNAMIC_DISPATCH gives. Until the process has
// called its first kernel that address is a stand-in, which asks the processor what it can do at
// every call: tens of microseconds each in a virtual machine.
inline void choose_vector_unit() {
  hwy::ChosenTarget& chosen = hwy::GetChosenTarget();
  if (!chosen.IsInitialized()) chosen.Update(hwy::SupportedTargets());
}

}  // namespace kibori
