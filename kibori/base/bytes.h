// SPDX-License-Identifier: MIT
// A buffer of bytes.
#pragma once

#include <cstdint>
#include <vector>

namespace kibori {

using Bytes = std::vector<uint8_t>;

}  // namespace kibori
