// SPDX-License-Identifier: MIT
// Queries available memory, so that work that cannot fit is refused before it starts. Also requests
// large pages.
#pragma once

#include <cstddef>

namespace kibori {

// Bytes that the system can still provide; 0 if it is unknown.
double available_bytes();

// Requests large pages for a block of memory that is not in use yet. Otherwise the first write to
// each small page costs a fault. This is only a hint.
void prefer_large_pages(void* block, size_t bytes);

}  // namespace kibori
