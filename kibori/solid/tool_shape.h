// SPDX-License-Identifier: MIT
// The definition of a tool shape. Each shape is one struct in one file of kibori/solid/tools/.
// kibori/solid/tool.h lists the shapes. In the frame of a shape, the tip is the origin, and the
// tool extends along +z. Lengths are in mm and angles in degrees. The concept ToolShape below lists
// the members of a shape.
#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <string>
#include <string_view>

#include <kibori/solid/swept_parts.h>

namespace kibori {

// Checks the numbers of a tool. Keeps the first fault as a sentence.
class ToolCheck {
 public:
  void require(bool condition, const std::string& sentence) {
    if (fault_.empty() && !condition) fault_ = sentence;
  }
  // Requires a finite number above 0.
  void positive(const char* name, double value);
  void between(const char* name, double value, double min, double max);
  void check_max(const char* name, double value, const char* max_name, double max);

  // Empty if there is no fault.
  const std::string& fault() const { return fault_; }

 private:
  std::string fault_;
};

template <class Shape>
concept ToolShape = std::equality_comparable<Shape> &&
    requires(const Shape& shape, ToolCheck& checks, SweptParts& parts) {
  // The shape's name in scenes, documents and messages.
  { Shape::kShape } -> std::convertible_to<std::string_view>;
  // One line for users: help of the Python module, docs/scenes.md.
  { Shape::kAbout } -> std::convertible_to<std::string_view>;
  // True if no ray can leave the tool and enter it again.
  { Shape::kIsConvex } -> std::convertible_to<bool>;
  // Calls f(name, number) for each number, in the order of declaration. A
  // number is a double or, for sizes along x, y and z, a Vec3.
  Shape::for_numbers(shape, [](const char*, const auto&) {});
  // Checks the numbers against each other. check_tool itself requires that all are positive.
  shape.check(checks);
  // Distance from the tip to the farthest point [mm].
  { shape.reach_mm() } -> std::same_as<double>;
  // Adds the parts of the swept tool.
  shape.add_parts(parts);
};

}  // namespace kibori
