// SPDX-License-Identifier: MIT
// The fields of a struct of settings, described once next to it and visited by the document codec,
// the scene reader, the Python module and tests:
//
//   static void for_fields(auto&& f) {
//     f(FieldInfo{"radius_mm", "radius", FieldRange::positive}, &Brush::radius_mm);
//     f(FieldInfo{"falloff", "falloff"}, &Brush::falloff);
//   }
//
// A type that a visitor can't handle does not compile.
#pragma once

#include <type_traits>

namespace kibori {

// What a scene may say of a number; the struct's own check has the rest.
enum class FieldRange { any, not_negative, positive };

// Whether documents hold the field.
enum class Stored {
  required,        // all do
  always,          // but for older ones
  unless_default,  // only where it is not the default
  where_used       // only where the rest of the stroke uses it: the codec knows where
};

struct FieldInfo {
  const char* key;   // in documents
  const char* name;  // in scenes and in Python
  FieldRange range = FieldRange::any;
  Stored stored = Stored::required;
};

// A struct whose fields are described.
template <class T>
concept Described = requires {
  T::for_fields([](const FieldInfo&, auto) {});
};

// What a member pointer points to.
template <class T, class Value>
std::type_identity<Value> member_type(Value T::*);
template <class Member>
using MemberType = typename decltype(member_type(Member{}))::type;

}  // namespace kibori
