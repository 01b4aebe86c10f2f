// SPDX-License-Identifier: MIT
// The page's files, which are part of the program: cmake/embed.cmake makes bundle.cpp of web/.
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
