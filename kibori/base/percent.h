// SPDX-License-Identifier: MIT
// Formats percentages in one style, for example 100 %, 99.7 % and 0.04 %.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace kibori {

// Formats a share (1 means all) as a percentage. The text normally has one decimal. Near 0 or 100,
// it has up to six, to show two digits of the value, or of its difference from 100. "100 %" and
// "0 %" are printed only if the value is within 0.000001 of 100 or 0. The text has no exponent, and
// its decimals do not end with zeros.
inline std::string percent(double share) {
  const double value = 100 * share, smaller = std::min(std::abs(value), std::abs(100 - value));
  const int decimals = smaller > 0 && std::isfinite(smaller)
                           ? std::clamp(1 - static_cast<int>(std::floor(std::log10(smaller))), 1, 6)
                           : 1;
  char text[340];  // the largest double has 309 digits
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  std::string number = text;
  if (const size_t point = number.find('.'); point != std::string::npos) {
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
  }
  return (number == "-0" ? "0" : number) + " %";
}

}  // namespace kibori
