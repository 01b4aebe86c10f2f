// SPDX-License-Identifier: MIT
// What Python's Model, Stroke, Snapshot and Body are.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <kibori/batch/workpiece.h>

#include "python/src/conversions.h"

namespace kibori::python {

// A piece that any thread may ask: one at a time, and without Python's lock meanwhile.
class Model : public std::enable_shared_from_this<Model> {
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

void bind_model(py::module_& module);

}  // namespace kibori::python
