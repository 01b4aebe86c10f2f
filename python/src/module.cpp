// SPDX-License-Identifier: MIT
// The module kibori._kibori: the C++ part of the Python package in python/kibori.
#include <cmath>
#include <exception>
#include <string_view>

#include <kibori/report/tick_records.h>
#include <kibori/haptics/force.h>
#include <kibori/haptics/hand.h>
#include <kibori/motion/tool_tick.h>

#include "python/src/conversions.h"
#include "python/src/materials.h"
#include "python/src/model.h"
#include "python/src/tools.h"

namespace {

template <class Enum>
pybind11::tuple names() {
  pybind11::list list;
  for (const std::string_view& name : names_of(Enum())) list.append(std::string(name));
  return pybind11::tuple(list);
}

}  // namespace

PYBIND11_MODULE(_kibori, module) {
  using namespace kibori;
  module.attr("__version__") = KIBORI_VERSION;
  static PyObject* error_class =
      pybind11::exception<python::Failure>(module, "Error", PyExc_RuntimeError).ptr();
  pybind11::setattr(
      error_class, "__doc__",
      pybind11::str("An operation that failed, as one sentence. The model is unchanged."));
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const python::Failure& failure) {
      // File names need not be UTF-8.
      const std::string_view text = failure.what();
      PyErr_SetObject(
          error_class,
          pybind11::reinterpret_steal<pybind11::object>(
              PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace"))
              .ptr());
    }
  });
  pybind11::list shapes;
  for (const char* shape : kToolShapes) shapes.append(shape);
  module.attr("SHAPES") = pybind11::tuple(shapes);
  module.attr("MODES") = names<Mode>();
  module.attr("FORCE_MODELS") = names<ForceModel>();
  module.def("_write_ticks_csv", [](const std::filesystem::path& document,
                                    const std::filesystem::path& to) {
    const pybind11::gil_scoped_release no_gil;
    const auto opened = python::value_of(Document::open(document, Document::Access::read));
    python::must(write_ticks_csv(to, *opened, opened->head()));
  });
  pybind11::class_<SimulatedHand>(module, "_SimulatedHand")
      .def(pybind11::init([](const python::Three& at, double hand_mass, double grip,
                             double grip_damping, double device_mass, double device_damping) {
        for (const double number : {hand_mass, grip, grip_damping, device_mass, device_damping})
          if (!(number >= 0) || !(number < 1e9))
            throw python::Failure("masses, stiffness and damping of a hand must be 0 or more");
        if (!(hand_mass + device_mass > 0)) throw python::Failure("a hand must have a mass");
        return SimulatedHand({hand_mass, grip, grip_damping, device_mass, device_damping},
                             python::vec(at));
      }))
      .def("step",
           [](SimulatedHand& hand, const python::Three& force, const python::Three& target,
              const python::Three& velocity, double seconds) {
             for (const python::Three& numbers : {force, target, velocity})
               if (!python::vec(numbers).allFinite())
                 throw python::Failure(
                     "force, target and velocity of a hand must be finite numbers");
             if (!(seconds >= 0) || !std::isfinite(seconds))
               throw python::Failure("seconds must be 0 or more");
             hand.step(python::vec(force), python::vec(target), python::vec(velocity), seconds);
             return python::three(hand.position_mm());
           })
      .def_property_readonly("work_mj", &SimulatedHand::work_mj)
      .def_property_readonly("min_work_mj", &SimulatedHand::min_work_mj);
  python::bind_tools(module);
  python::bind_materials(module);
  python::bind_model(module);
  python::bind_servo(module);
  python::bind_milling(module);
}
