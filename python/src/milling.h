// SPDX-License-Identifier: MIT
// Arguments and errors that kibori.mill and kibori.Milling share.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/run/milling_plan.h>

#include "python/src/conversions.h"
#include "python/src/model.h"

namespace kibori::python {

using Path = std::filesystem::path;
// A block, a file or a Model.
using MillingStock = std::variant<std::array<double, 6>, Path, Shared>;

struct MillingArguments {
  std::optional<MillingStock> stock;
  std::optional<double> pitch, tolerance;
  std::optional<Path> tools, machine, target;
  std::optional<int> tool;
  std::optional<std::string> material;
  std::vector<Path> fixtures;
  bool z_only = false;
  int threads = 1;
};

// `model`: receives a copy of a stock that is a Model. `warnings` must outlive the request.
MillRequest request_of(const MillingArguments& given, std::unique_ptr<TriDexel>& model,
                       std::vector<std::string>& warnings);
// Checks the outputs as the command line does. An empty path means that there is no such output.
void check_outputs(const MillPlan& plan, const MillingArguments& given, const Path& mesh,
                   const Path& document);

// Removes "--" before options of the command line that a sentence of the library names. Python's
// arguments have the same names.
std::string of_python(std::string text);
template <class T>
T done(Result<T> result) {
  if (!result) throw Failure(of_python(result.error()));
  return std::move(result).value();
}
// Issues a Python warning for each text.
void warn(const std::vector<std::string>& warnings);
// Runs pending signal handlers (Ctrl-C) and raises their exception. Takes Python's lock (GIL).
void check_signals();
// The value of a JSON text.
py::object parsed(const std::string& json);

void bind_mill(py::module_& module);

}  // namespace kibori::python
