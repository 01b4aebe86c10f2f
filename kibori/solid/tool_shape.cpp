// SPDX-License-Identifier: MIT
#include <kibori/solid/tool_shape.h>

#include <cstdio>

namespace kibori {
namespace {

template <class... Args>
std::string sentence(const char* format, Args... args) {
  char text[128];
  std::snprintf(text, sizeof text, format, args...);
  return text;
}

}  // namespace

void ToolCheck::positive(const char* name, double value) {
  if (!(value > 0 && std::isfinite(value)))
    require(false, sentence("%s must be a positive number, not %g", name, value));
}

void ToolCheck::between(const char* name, double value, double min, double max) {
  if (!(value >= min && value <= max))
    require(false, sentence("%s must be between %g and %g", name, min, max));
}

void ToolCheck::check_max(const char* name, double value, const char* max_name, double max) {
  if (!(value <= max)) require(false, sentence("%s must not exceed %s", name, max_name));
}

}  // namespace kibori
