// SPDX-License-Identifier: MIT
// What Python's Model is.
#pragma once

#include <array>
#include <memory>
#include <mutex>

#include <kibori/batch/workpiece.h>

#include "python/src/conversions.h"

namespace kibori::python {

// A piece that any thread may ask: one at a time, and without Python's lock meanwhile.
class Model {
 public:
  explicit Model(std::unique_ptr<Workpiece> piece) : piece_(std::move(piece)) {}

  template <class F>
  auto with(F&& f) {
    const py::gil_scoped_release no_gil;
    const std::lock_guard<std::mutex> lock(mutex_);
    return f(*piece_);
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<Workpiece> piece_;
};

using Shared = std::shared_ptr<Model>;
using ModelClass = py::class_<Model, Shared>;

// Lattice nodes along x, y and z.
std::array<py::ssize_t, 3> shape_of(const Lattice& lattice);

void bind_model(py::module_& module);
void bind_stocks(ModelClass& model);
void bind_strokes(py::module_& module, ModelClass& model);
void bind_arrays(py::module_& module, ModelClass& model);
void bind_bodies(py::module_& module, ModelClass& model);

}  // namespace kibori::python
