// SPDX-License-Identifier: MIT
// Converts the values of an enum to names and back, for files, messages and command lines. An enum
// with names has a function names_of next to it. This function returns the names in the order of
// the values:
//
//   enum class Mode { cut, deposit };
//   constexpr Names<2> names_of(Mode) { return {"cut", "deposit"}; }
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace kibori {

template <size_t N>
using Names = std::array<std::string_view, N>;

template <class Enum>
concept Named = requires(Enum value) {
  names_of(value).size();
};

// Returns the name of a value.
template <Named Enum>
constexpr std::string_view name_of(Enum value) {
  return names_of(value)[static_cast<size_t>(value)];
}

// Returns the value with this name; nullopt if there is none.
template <Named Enum>
constexpr std::optional<Enum> value_of(std::string_view name) {
  const auto names = names_of(Enum{});
  for (size_t i = 0; i < names.size(); i++)
    if (names[i] == name) return static_cast<Enum>(i);
  return std::nullopt;
}

}  // namespace kibori
