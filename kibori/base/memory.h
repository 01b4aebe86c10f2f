// SPDX-License-Identifier: MIT
// How much memory there is, so that work which can't fit is refused before it starts.
#pragma once

namespace kibori {

// Bytes the system can still give; 0 where it does not say.
double available_bytes();

}  // namespace kibori
