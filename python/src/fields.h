// SPDX-License-Identifier: MIT
// Reads and writes described structs (kibori/base/field_info.h) by the names of their fields.
#pragma once

#include <array>
#include <string>
#include <type_traits>

#include <kibori/base/field_info.h>
#include <kibori/base/names.h>

#include "python/src/conversions.h"

namespace kibori::python {

// The names of all fields, as in "radius, strength", including those of nested structs.
template <Described T>
std::string field_names() {
  std::string names;
  T::for_fields([&](const FieldInfo& field, auto member) {
    if (!names.empty()) names += ", ";
    if constexpr (Described<MemberType<decltype(member)>>)
      names += field_names<MemberType<decltype(member)>>();
    else
      names += field.name;
  });
  return names;
}

template <class Value>
void set_value(Value& into, const char* name, const py::handle& value, const std::string& what) {
  if constexpr (Named<Value>)
    into = named<Value>(name, given<std::string>(value, what));
  else if constexpr (std::is_same_v<Value, Vec3>)
    into = vec(given<Three>(value, what));
  else if constexpr (std::is_same_v<Value, std::array<double, 3>>)  // or one number for all three
    if (py::isinstance<py::float_>(value) || py::isinstance<py::int_>(value))
      into.fill(given<double>(value, what));
    else
      into = given<std::array<double, 3>>(value, what);
  else
    into = given<Value>(value, what);
}

// Sets the field of that name. Returns false if there is none. `what`: text of a TypeError.
template <Described T>
bool set_field(T& into, const std::string& name, const py::handle& value, const std::string& what) {
  bool found = false;
  T::for_fields([&](const FieldInfo& field, auto member) {
    if constexpr (Described<MemberType<decltype(member)>>) {
      found = found || set_field(into.*member, name, value, what);
    } else if (name == field.name) {
      set_value(into.*member, field.name, value, what);
      found = true;
    }
  });
  return found;
}

}  // namespace kibori::python
