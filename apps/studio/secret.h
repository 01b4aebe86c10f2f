// SPDX-License-Identifier: MIT
// Makes and compares random secrets. Internal to apps/studio.
#pragma once

#include <string>
#include <string_view>

namespace kibori::studio {

// Returns 256 random bits as hexadecimal digits.
std::string random_hex();

// Compares two secrets. The time does not depend on the position of a difference. It may depend on
// the lengths, which are not secret.
bool same_secret(std::string_view a, std::string_view b);

}  // namespace kibori::studio
