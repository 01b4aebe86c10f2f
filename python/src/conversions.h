// SPDX-License-Identifier: MIT
// Conversions between Kibori's and Python's values: errors, positions, poses, arrays.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <kibori/base/file.h>
#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori::python {

namespace py = pybind11;

// Raised as kibori.Error.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class T>
T value_of(Result<T> result) {
  if (!result) throw Failure(result.error());
  return std::move(result).value();
}
inline void must(const Status& status) {
  if (!status) throw Failure(status.error());
}

// Converts a Python value to T. If that is impossible, raises a TypeError with the text `what`.
template <class T>
T given(const py::handle& value, const std::string& what) {
  try {
    return py::cast<T>(value);
  } catch (const py::cast_error&) {
    throw py::type_error(what);
  }
}

// Finds an enumerator by name. Errors: an unknown name; the message lists the known ones.
template <class Enum>
Enum named(const std::string& what, const std::string& name) {
  const auto value = kibori::value_of<Enum>(name);
  if (value) return *value;
  std::string known;
  for (const std::string_view& one : names_of(Enum())) {
    if (!known.empty()) known += ", ";
    known += one;
  }
  throw Failure("there is no " + what + " '" + sanitize_message(name) + "'; there are " + known);
}

using Three = std::array<double, 3>;
inline Vec3 vec(const Three& v) { return {v[0], v[1], v[2]}; }
inline Three three(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// The share of the cutting force that the hand receives if a tool is `powered` by "", "motor" or
// "press". Errors: another word.
double share_of(const std::string& powered);

// A contiguous array of doubles. As an argument, it accepts real numbers in any form that NumPy can
// convert to an array. Complex numbers, text and other objects raise TypeError.
struct Doubles : py::array_t<double, py::array::c_style | py::array::forcecast> {
  using py::array_t<double, py::array::c_style | py::array::forcecast>::array_t;
};

// The poses of a path. A row is x, y, z, or x, y, z and a quaternion x, y, z, w. ROS and SciPy use
// this order. Errors: other shapes, non-finite numbers, a quaternion whose length is not 1.
std::vector<Pose> poses_of(const Doubles& rows);
Pose pose_of(const Doubles& row);

// An array of `shape` that owns `data`.
template <class T>
py::array_t<T> array_of(std::vector<T> data, std::vector<py::ssize_t> shape) {
  auto* const kept = new std::vector<T>(std::move(data));
  const py::capsule owner(kept, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(std::move(shape), kept->data(), owner);
}

}  // namespace kibori::python

namespace pybind11::detail {

template <>
struct type_caster<kibori::python::Doubles> {
  PYBIND11_TYPE_CASTER(kibori::python::Doubles, const_name("numpy.ndarray[numpy.float64]"));
  bool load(handle source, bool) {
    const array any = array::ensure(source);
    if (!any) {
      PyErr_Clear();
      return false;
    }
    const char kind = any.dtype().kind();
    if (kind != 'f' && kind != 'i' && kind != 'u')
      throw type_error("the argument must be an array of numbers, not of " +
                       pybind11::cast<std::string>(str(any.dtype())));
    value = reinterpret_borrow<kibori::python::Doubles>(
        array_t<double, array::c_style | array::forcecast>(any));
    return true;
  }
};

}  // namespace pybind11::detail
