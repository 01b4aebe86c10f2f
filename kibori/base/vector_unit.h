// SPDX-License-Identifier: MIT
// Initialises Highway's choice of a vector unit.
#pragma once

#include <hwy/targets.h>

namespace kibori {

// Call this before you store the address from HWY_DYNAMIC_DISPATCH. Before the process calls its
// first kernel, that address is a stub that queries the processor at every call. In a virtual
// machine, each query takes tens of microseconds.
inline void choose_vector_unit() {
  hwy::ChosenTarget& chosen = hwy::GetChosenTarget();
  if (!chosen.IsInitialized()) chosen.Update(hwy::SupportedTargets());
}

}  // namespace kibori
