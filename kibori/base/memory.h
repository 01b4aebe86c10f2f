// SPDX-License-Identifier: MIT
// How much memory there is, so that work which can't fit is refused before it starts; and large
// pages.
#pragma once

#include <cstddef>

namespace kibori {

// Bytes the system can still give; 0 where it does not say.
double available_bytes();

// Asks for large pages where a block of memory is not in use yet: a block that is filled once costs
// a fault a page. Only a hint.
void prefer_large_pages(void* block, size_t bytes);

}  // namespace kibori
