// SPDX-License-Identifier: MIT
// Describes the fields of a settings struct once, next to the struct: the function for_fields calls
// a visitor `f` for each field. The document codec, the scene reader, the Python module and tests
// pass such visitors:
//
//   static void for_fields(auto&& f) {
//     f(FieldInfo{"radius_mm", "radius", FieldRange::positive}, &Brush::radius_mm);
//     f(FieldInfo{"falloff", "falloff"}, &Brush::falloff);
//   }
//
// If a visitor cannot handle the type of a field, the code does not compile.
#pragma once

#include <type_traits>

namespace kibori {

// Range of the numbers that a scene may give for a field. The struct's own check may be stricter.
enum class FieldRange { any, not_negative, positive };

// The documents that store the field.
enum class Stored {
  required,        // all documents
  always,          // all documents, except those of older versions
  unless_default,  // documents in which the field is not the default
  where_used       // documents in which other settings of the stroke use it; the codec decides
};

struct FieldInfo {
  const char* key;   // the field's name in documents
  const char* name;  // the field's name in scenes and in Python
  FieldRange range = FieldRange::any;
  Stored stored = Stored::required;
};

// A struct that describes its fields by for_fields.
template <class T>
concept Described = requires {
  T::for_fields([](const FieldInfo&, auto) {});
};

// The type of the member that a member pointer points to.
template <class T, class Value>
std::type_identity<Value> member_type(Value T::*);
template <class Member>
using MemberType = typename decltype(member_type(Member{}))::type;

}  // namespace kibori
