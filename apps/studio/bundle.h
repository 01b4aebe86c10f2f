// SPDX-License-Identifier: MIT
// The files of the page. They are embedded in the program: cmake/embed.cmake makes bundle.cpp of
// web/.
#pragma once

#include <cstddef>
#include <span>

namespace kibori::studio {

struct BundledFile {
  const char* path;  // for example "/index.html"
  const unsigned char* data;
  size_t size;
};
std::span<const BundledFile> bundle();

}  // namespace kibori::studio
