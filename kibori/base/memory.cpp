// SPDX-License-Identifier: MIT
#include <kibori/base/memory.h>

#include <cstdint>
#include <fstream>
#include <string>

#include <sys/mman.h>

namespace kibori {

double available_bytes() {
  std::ifstream info("/proc/meminfo");
  std::string key;
  for (double kilobytes; info >> key >> kilobytes; info.ignore(256, '\n'))
    if (key == "MemAvailable:") return kilobytes * 1024;
  return 0;
}

void prefer_large_pages(void* block, size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr uintptr_t kPage = 4096;
  // Whole pages only.
  const size_t skip = (kPage - reinterpret_cast<uintptr_t>(block) % kPage) % kPage;
  if (bytes < skip + kPage) return;
  madvise(static_cast<char*>(block) + skip, (bytes - skip) / kPage * kPage, MADV_HUGEPAGE);
#else
  static_cast<void>(block), static_cast<void>(bytes);
#endif
}

}  // namespace kibori
