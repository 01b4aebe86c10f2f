// SPDX-License-Identifier: MIT
// Makes Highway choose a vector unit before the first kernel runs.
#pragma once

#include <hwy/targets.h>

namespace kibori {

// Call this before you store an address from HWY_DYNAMIC_DISPATCH. Until the process has called its
// first kernel, such an address is a stub. The stub queries the processor at every call. In a
// virtual machine, each query takes tens of microseconds.
inline void choose_vector_unit() {
  hwy::ChosenTarget& chosen = hwy::GetChosenTarget();
  if (!chosen.IsInitialized()) chosen.Update(hwy::SupportedTargets());
}

}  // namespace kibori
