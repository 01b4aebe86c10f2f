// SPDX-License-Identifier: MIT
// kibori.mill: runs whole programs, as the command `kibori mill`.
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <kibori/formats/surface_file.h>
#include <kibori/report/convert.h>
#include <kibori/report/mill_report.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling_plan.h>

#include "python/src/milling.h"

namespace kibori::python {

std::string of_python(std::string text) {
  for (size_t at = 0; (at = text.find("--", at)) != std::string::npos;)
    if (at + 2 < text.size() && 'a' <= text[at + 2] && text[at + 2] <= 'z' &&
        (at == 0 || text[at - 1] == ' '))
      text.erase(at, 2);
    else
      at += 2;
  return text;
}
void warn(const std::vector<std::string>& warnings) {
  for (const std::string& text : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, sanitize_message(of_python(text)).c_str(), 1) != 0)
      throw py::error_already_set();
}

void check_signals() {
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

py::object parsed(const std::string& json) {
  return py::module_::import("json").attr("loads")(json);
}

namespace {

double positive(const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw Failure(std::string(name) + " must be a positive number of mm");
  return value;
}

}  // namespace

MillRequest request_of(const MillingArguments& given, std::unique_ptr<TriDexel>& model,
                       std::vector<std::string>& warnings) {
  MillRequest request;
  if (given.stock) {
    if (const auto* box = std::get_if<std::array<double, 6>>(&*given.stock)) {
      const auto& n = *box;
      request.stock = Box{Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5])};
      for (const double number : n)
        if (!std::isfinite(number)) throw Failure("the corners of stock must be finite numbers");
    } else if (const auto* path = std::get_if<Path>(&*given.stock)) {
      request.stock = *path;
    } else {
      const Shared& piece = std::get<Shared>(*given.stock);
      if (!piece) throw py::type_error("stock must be six numbers, a file or a Model");
      model = piece->with([](Workpiece& of) {
        return std::make_unique<TriDexel>(of.model().snapshot(), of.model().material_bounds());
      });
    }
  }
  if (given.pitch) request.pitch_mm = positive("pitch", *given.pitch);
  if (given.tolerance) request.tolerance_mm = positive("tolerance", *given.tolerance);
  if (given.tools) request.tools = *given.tools;
  if (given.machine) request.machine = *given.machine;
  if (given.target) request.target = *given.target;
  if (given.tool && (*given.tool < 1 || *given.tool > 99999))
    throw Failure("tool must be the number of a tool, 1 to 99999");
  if (given.threads < 1 || given.threads > 256) throw Failure("threads must be 1 to 256");
  request.tool = given.tool;
  request.material = given.material;
  request.fixtures = given.fixtures;
  request.z_only = given.z_only;
  request.threads = given.threads;
  request.warning = [&warnings](const std::string& text) { warnings.push_back(text); };
  return request;
}

void check_outputs(const MillPlan& plan, const MillingArguments& given, const Path& mesh,
                   const Path& document) {
  if (given.z_only && (!mesh.empty() || !document.empty() || plan.has_target()))
    throw Failure(
        "z_only computes no surface; omit it to write a mesh or a document, or to compare with a "
        "target");
  if (given.tolerance && !plan.has_target())
    throw Failure("tolerance needs the part to compare with; give it as target");
  if (!mesh.empty()) must(check_surface_ending(mesh));
  std::vector<Path> inputs = given.fixtures;
  for (const auto& file : {given.tools, given.machine, given.target})
    if (file) inputs.push_back(*file);
  for (const MillSetup& setup : plan.setups)
    inputs.insert(inputs.end(), setup.programs.begin(), setup.programs.end());
  if (plan.stock && std::holds_alternative<Path>(*plan.stock))
    inputs.push_back(std::get<Path>(*plan.stock));
  std::error_code unknown;
  for (const Path& input : inputs)
    if (!mesh.empty() && std::filesystem::equivalent(mesh, input, unknown))
      throw Failure(mesh.string() + ": is an input; name another file for mesh");
  if (!document.empty() && !is_document(document))
    throw Failure(document.string() + ": documents are written as .kibori");
  std::error_code error;
  if (!document.empty() && std::filesystem::exists(document, error))
    throw Failure(document.string() + ": exists already; documents are never overwritten");
}

namespace {

py::object mill(const std::variant<Path, std::vector<Path>>& programs,
                const MillingArguments& given, const std::optional<Path>& mesh,
                const std::optional<Path>& document) {
  std::unique_ptr<TriDexel> model;
  std::vector<std::string> warnings;
  MillRequest request = request_of(given, model, warnings);
  if (const auto* one = std::get_if<Path>(&programs))
    request.programs = {*one};
  else
    request.programs = std::get<std::vector<Path>>(programs);
  if (request.programs.empty()) throw Failure("there is no program; name at least one file");
  const Path mesh_path = mesh.value_or(Path()), document_path = document.value_or(Path());
  std::string report;
  {
    const py::gil_scoped_release no_gil;
    MillPlan plan = done(plan_milling(request, std::move(model)));
    check_outputs(plan, given, mesh_path, document_path);
    done(make_models(plan));
    for (MillSetup& setup : plan.setups)
      setup.options.progress = [](size_t, int) { check_signals(); };
    MillPlanOptions options;
    options.document = document_path;
    done(run_plan(plan, options));
    if (!mesh_path.empty()) {
      std::vector<Rgb> colors;
      for (const Material& material : plan.materials) colors.push_back(material.color);
      done(write_model(mesh_path, plan.model->snapshot(), colors, 0, given.threads));
    }
    report = mill_json(results_of(plan));
  }
  warn(warnings);
  return parsed(report);
}

}  // namespace

void bind_mill(py::module_& module) {
  module.def(
      "mill",
      [](const std::variant<Path, std::vector<Path>>& programs,
         const std::optional<MillingStock>& stock, const std::optional<Path>& tools,
         const std::optional<int>& tool, const std::optional<Path>& machine,
         const std::optional<double>& pitch, const std::optional<std::string>& material,
         const std::vector<Path>& fixtures, const std::optional<Path>& target,
         const std::optional<double>& tolerance, const std::optional<Path>& mesh,
         const std::optional<Path>& document, bool z_only, int threads) {
        return mill(programs,
                    {stock, pitch, tolerance, tools, machine, target, tool, material, fixtures,
                     z_only, threads},
                    mesh, document);
      },
      py::arg("programs"), py::kw_only(), py::arg("stock") = py::none(),
      py::arg("tools") = py::none(), py::arg("tool") = py::none(), py::arg("machine") = py::none(),
      py::arg("pitch") = py::none(), py::arg("material") = py::none(),
      py::arg("fixtures") = std::vector<Path>(), py::arg("target") = py::none(),
      py::arg("tolerance") = py::none(), py::arg("mesh") = py::none(),
      py::arg("document") = py::none(), py::arg("z_only") = false, py::arg("threads") = 1,
      "Runs programs of a milling machine, or a job file, and returns the report of kibori mill "
      "--json as a dict. stock: a block x0, y0, z0, x1, y1, z1 [mm], a mesh or document file, or a "
      "Model, which does not change. tools, machine: files. tool: number of the tool in the "
      "spindle "
      "at the start. pitch: size of a cell [mm]. fixtures, target: mesh files. tolerance: of the "
      "target [mm]. mesh, document: files to write. docs/milling.md explains all of them.");
}

}  // namespace kibori::python
