// SPDX-License-Identifier: MIT
// The class behind Python's Model.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

#include <kibori/run/workpiece.h>

#include "python/src/conversions.h"

namespace kibori::python {

// A value that any thread may use. Calls run one at a time, without Python's lock (GIL).
template <class T>
class Guarded {
 public:
  // `busy`: the error of a call by the thread that is already in one.
  Guarded(std::unique_ptr<T> value, const char* busy) : value_(std::move(value)), busy_(busy) {}

  template <class F>
  auto with(F&& f) {
    // A signal handler can run on the thread that is already in a call.
    if (owner_ == std::this_thread::get_id()) throw Failure(busy_);
    const py::gil_scoped_release no_gil;
    const std::lock_guard<std::mutex> lock(mutex_);
    const Owned owned(owner_);
    return f(*value_);
  }

 private:
  struct Owned {
    explicit Owned(std::atomic<std::thread::id>& of) : owner(of) {
      owner = std::this_thread::get_id();
    }
    ~Owned() { owner = std::thread::id(); }
    std::atomic<std::thread::id>& owner;
  };

  std::mutex mutex_;
  std::atomic<std::thread::id> owner_;
  std::unique_ptr<T> value_;
  const char* busy_;
};

class Model : public Guarded<Workpiece> {
 public:
  explicit Model(std::unique_ptr<Workpiece> piece)
      : Guarded(std::move(piece), "the model is being carved; call it again afterwards") {}
};

using Shared = std::shared_ptr<Model>;
using ModelClass = py::class_<Model, Shared>;

// The number of lattice nodes along x, y and z.
std::array<py::ssize_t, 3> shape_of(const Lattice& lattice);

void bind_model(py::module_& module);
void bind_stocks(ModelClass& model);
void bind_strokes(py::module_& module, ModelClass& model);
void bind_arrays(py::module_& module, ModelClass& model);
void bind_servo(py::module_& module);
void bind_bodies(py::module_& module, ModelClass& model);
void bind_milling(py::module_& module);

// The surface of a state as a Python object of the class Surface.
py::object surface_arrays(const kibori::Snapshot& snapshot, int threads);

}  // namespace kibori::python
