// SPDX-License-Identifier: MIT
// Describes the fields of a settings struct once, next to the struct. The document codec, the scene
// reader, the Python module and tests visit the description:
//
//   static void for_fields(auto&& f) {
//     f(FieldInfo{"radius_mm", "radius", FieldRange::positive}, &Brush::radius_mm);
//     f(FieldInfo{"falloff", "falloff"}, &Brush::falloff);
//   }
//
// A type that a visitor cannot handle does not compile.
#pragma once

#include <type_traits>

namespace kibori {

// The range of a number that a scene may give. The struct's own check tests the rest.
enum class FieldRange { any, not_negative, positive };

// When documents store the field.
enum class Stored {
  required,        // in all documents
  always,          // in all documents except older ones
  unless_default,  // only if it is not the default
  where_used       // only if other settings of the stroke use it; the codec decides
};

struct FieldInfo {
  const char* key;   // in documents
  const char* name;  // in scenes and in Python
  FieldRange range = FieldRange::any;
  Stored stored = Stored::required;
};

// A struct that describes its fields.
template <class T>
concept Described = requires {
  T::for_fields([](const FieldInfo&, auto) {});
};

// The type that a member pointer points to.
template <class T, class Value>
std::type_identity<Value> member_type(Value T::*);
template <class Member>
using MemberType = typename decltype(member_type(Member{}))::type;

}  // namespace kibori
