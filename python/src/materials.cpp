// SPDX-License-Identifier: MIT
#include "python/src/materials.h"

#include <algorithm>

#include <kibori/haptics/materials.h>

#include "python/src/fields.h"

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

namespace {

Material make_material(const std::string& name, double u, const py::kwargs& more) {
  Material material;
  material.name = name;
  material.u = u;
  for (const auto& [key, value] : more) {
    const auto field = py::cast<std::string>(key);
    if (!set_field(material, field, value, "a material's " + field + " is not of that kind"))
      throw py::type_error("a material has no '" + field + "'; it has " + field_names<Material>());
  }
  Material::for_fields([&](const FieldInfo&, auto member) {
    if constexpr (std::is_same_v<MemberType<decltype(member)>, double>)
      if (!(material.*member >= 0) || !(material.*member < 1e9))
        throw Failure("a material's numbers are 0 or more");
  });
  if (name.empty()) throw Failure("a material has a name");
  if (material.ring > kMaxRing) throw Failure("ring is at most 5");
  return material;
}

}  // namespace

void bind_materials(py::module_& module) {
  py::class_<Material> material(
      module, "Material",
      "Material(name, u, kf=..., u_along=0, ring=0, ...): what is carved.\n\n"
      "u: specific cutting energy [N/mm^2]; u_along: the same along the grain (0: as across);\n"
      "ring: by what share of u late wood of a ring resists more than early wood (0 to 5);\n"
      "kf: force of a lattice node [N], of the force model paper; c: viscous part of the force\n"
      "[N s/mm^3], and yield_n: least force that cuts [N], of the force model series;\n"
      "gc: work of a cutter's cut [N/mm]; color: red, green, blue, 0 to 255;\n"
      "plastic: whether a tool presses it aside, as clay.");
  material.def(py::init(&make_material), py::arg("name"), py::arg("u"));
  Material::for_fields(
      [&](const FieldInfo& field, auto member) { material.def_readonly(field.name, member); });
  material.def("__repr__",
               [](const Material& self) { return "<kibori.Material " + self.name + ">"; });
  module.def(
      "known_materials", [] { return known_materials(); }, "Those that are known by name.");
}

}  // namespace kibori::python
