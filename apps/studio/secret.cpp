// SPDX-License-Identifier: MIT
#include "apps/studio/secret.h"

#include <cstdio>
#include <random>

namespace kibori::studio {

std::string random_hex() {
  std::random_device random;
  std::string text;
  for (int i = 0; i < 8; i++) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(random()));
    text += digits;
  }
  return text;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differ = 0;
  for (size_t i = 0; i < a.size(); i++)
    differ |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differ == 0;
}

}  // namespace kibori::studio
