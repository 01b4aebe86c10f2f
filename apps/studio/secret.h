// SPDX-License-Identifier: MIT
// Random secrets and their comparison. Internal to apps/studio.
#pragma once

#include <string>
#include <string_view>

namespace kibori::studio {

// 256 random bits.
std::string random_hex();

// Compares in constant time, independent of the position of a difference. Lengths are not secret.
bool same_secret(std::string_view a, std::string_view b);

}  // namespace kibori::studio
