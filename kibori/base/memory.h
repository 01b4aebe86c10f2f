// SPDX-License-Identifier: MIT
// Reports the available memory, so that work that needs more is refused before it starts. Also
// requests large memory pages.
#pragma once

#include <cstddef>

namespace kibori {

// Returns the number of bytes that the system can still provide; 0 if it is unknown.
double available_bytes();

// Asks the system to use large pages for a block of memory. Call it before the first write to the
// block. With small pages, the first write to each page causes a page fault. The system may ignore
// the request.
void prefer_large_pages(void* block, size_t bytes);

}  // namespace kibori
