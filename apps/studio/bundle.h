// SPDX-License-Identifier: MIT
// The files of the page, embedded in the program. cmake/embed.cmake makes bundle.cpp from web/.
#pragma once

#include <cstddef>
#include <span>

namespace kibori::studio {

struct BundledFile {
  const char* path;  // "/index.html"
  const unsigned char* data;
  size_t size;
};
std::span<const BundledFile> bundle();

}  // namespace kibori::studio
