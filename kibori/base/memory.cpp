// SPDX-License-Identifier: MIT
#include <kibori/base/memory.h>

#include <fstream>
#include <string>

namespace kibori {

double available_bytes() {
  std::ifstream info("/proc/meminfo");
  std::string key;
  for (double kilobytes; info >> key >> kilobytes; info.ignore(256, '\n'))
    if (key == "MemAvailable:") return kilobytes * 1024;
  return 0;
}

}  // namespace kibori
