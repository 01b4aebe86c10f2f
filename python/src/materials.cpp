// SPDX-License-Identifier: MIT
#include "python/src/materials.h"

#include <algorithm>

#include <kibori/haptics/materials.h>

namespace kibori::python {

Material material_named(const MaterialOrName& wanted) {
  if (const auto* const own = std::get_if<Material>(&wanted)) return *own;
  const std::string& name = std::get<std::string>(wanted);
  std::string known;
  for (const Material& material : known_materials()) {
    if (material.name == name) return material;
    known += known.empty() ? material.name : ", " + material.name;
  }
  throw Failure("no material is called '" + sanitize_message(name) + "'; known are " + known +
                ", or make one: kibori.Material(name=..., u=...)");
}

uint8_t number_of(Workpiece& piece, const std::optional<MaterialOrName>& wanted) {
  if (!wanted) return 0;
  std::vector<Material>& all = piece.materials();
  const auto* const name = std::get_if<std::string>(&*wanted);
  const auto there = std::find_if(all.begin(), all.end(), [&](const Material& material) {
    return name ? material.name == *name : material == std::get<Material>(*wanted);
  });
  if (there != all.end()) return static_cast<uint8_t>(there - all.begin());
  if (all.size() >= kMaxMaterials)
    throw Failure("a piece has at most " + std::to_string(kMaxMaterials) + " materials");
  all.push_back(material_named(*wanted));
  return static_cast<uint8_t>(all.size() - 1);
}

void bind_materials(py::module_& module) {
  py::class_<Material>(
      module, "Material",
      "Material(name, u, kf=..., u_along=0, ring=0, ...): what is carved.\n\n"
      "u: specific cutting energy [N/mm^2]; u_along: the same along the grain (0: as across);\n"
      "ring: by what share of u late wood of a ring resists more than early wood (0 to 5);\n"
      "kf: force of a lattice node [N], of the force model paper; c: viscous part of the force\n"
      "[N s/mm^3], and yield_n: least force that cuts [N], of the force model series;\n"
      "gc: work of a cutter's cut [N/mm]; color: red, green, blue, 0 to 255;\n"
      "plastic: whether a tool presses it aside, as clay.")
      .def(py::init([](const std::string& name, double u, double kf, double c, double yield_n,
                       const std::array<uint8_t, 3>& color, bool plastic, double gc, double u_along,
                       double ring) {
             for (const double number : {u, kf, c, yield_n, gc, u_along, ring})
               if (!(number >= 0) || !(number < 1e9))
                 throw Failure("a material's numbers are 0 or more");
             if (name.empty()) throw Failure("a material has a name");
             if (ring > kMaxRing) throw Failure("ring is at most 5");
             return Material{name, kf, u, c, yield_n, color, plastic, gc, u_along, ring};
           }),
           py::arg("name"), py::arg("u"), py::kw_only(), py::arg("kf") = 0.001, py::arg("c") = 0.0,
           py::arg("yield_n") = 0.0, py::arg("color") = std::array<uint8_t, 3>{196, 154, 108},
           py::arg("plastic") = false, py::arg("gc") = 0.3, py::arg("u_along") = 0.0,
           py::arg("ring") = 0.0)
      .def_readonly("name", &Material::name)
      .def_readonly("u", &Material::u)
      .def_readonly("kf", &Material::kf)
      .def_readonly("c", &Material::c)
      .def_readonly("yield_n", &Material::yield_n)
      .def_readonly("color", &Material::color)
      .def_readonly("plastic", &Material::plastic)
      .def_readonly("gc", &Material::gc)
      .def_readonly("u_along", &Material::u_along)
      .def_readonly("ring", &Material::ring)
      .def("__repr__",
           [](const Material& material) { return "<kibori.Material " + material.name + ">"; });
  module.def(
      "known_materials", [] { return known_materials(); }, "Those that are known by name.");
}

}  // namespace kibori::python
