// SPDX-License-Identifier: MIT
// The one way a percentage is written: 100 %, 99.7 %, 0.04 %.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace kibori {

// A share (1 is all) in percent: one decimal, or as many as give two digits of what is there or of
// what is missing, so that 100 % means all and 0 % none (to a millionth of a percent); no
// exponents, no trailing zeros.
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
