// SPDX-License-Identifier: MIT
#include "python/src/materials.h"

#include <algorithm>

#include <kibori/haptics/materials.h>

#include "python/src/fields.h"

namespace kibori::python {

Material material_named(const MaterialOrName& wanted) {
  if (const auto* const own = std::get_if<Material>(&wanted)) return *own;
  const std::string& name = std::get<std::string>(wanted);
  if (const Material* material = known_material(name)) return *material;
  std::string known;
  for (const Material& material : known_materials())
    known += known.empty() ? material.name : ", " + material.name;
  throw Failure("there is no material '" + sanitize_message(name) + "'; known are " + known +
                ", or create one: kibori.Material(name=..., u=...)");
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

Material make_material(const std::string& name, const std::optional<double>& u,
                       const py::kwargs& more) {
  Material material;
  material.name = name;
  if (u.has_value() == more.contains("k"))
    throw py::type_error("a material needs either u or k, its specific cutting force");
  if (u) material.u = *u;
  for (const auto& [key, value] : more) {
    const auto field = py::cast<std::string>(key);
    if (!set_field(material, field, value, "a material's " + field + " has the wrong type"))
      throw py::type_error("a material has no '" + field + "'; it has " + field_names<Material>());
  }
  if (!u) material.u = mean_cutting_energy(material);
  if (name.empty()) throw Failure("a material needs a name");
  if (const char* fault = fault_of(material)) throw Failure(fault);
  return material;
}

}  // namespace

void bind_materials(py::module_& module) {
  py::class_<Material> material(
      module, "Material",
      "Material(name, u=..., ...) or Material(name, k=..., m=0, ...): a material that is "
      "carved.\n\n"
      "u: specific cutting energy [N/mm^2]: the force is u times the section of the chip.\n"
      "k: specific cutting force [N/mm^(2-m)], one number, or three for wood: a cut through end\n"
      "grain, along the fibres, across them. The force is k * width * thickness^(1-m).\n"
      "m: exponent of the thickness of the chip, 0 to below 1 (wood 0.5, metals 0.2 to 0.3).\n"
      "density: [kg/m^3], for masses; 0: unknown, and mass_g is None.\n"
      "ring_width: width of a year ring [mm]; axis, pith: direction of the fibres, point of the "
      "pith\n"
      "[mm]; by default they follow the shape of the stock.\n"
      "ring: share by which late wood of a ring resists more than early wood (0 to 5);\n"
      "u_along: u along the grain; u is then that across it (older documents; 0: same as across);\n"
      "kf: force of a lattice node [N], for the force model paper; c: viscous part of the force\n"
      "[N s/mm^3], and yield_n: min force that cuts [N], for the force model series;\n"
      "gc: energy to split it [N/mm]; color: red, green, blue, 0 to 255;\n"
      "plastic: True if a tool presses it aside, like clay.");
  material.def(py::init(&make_material), py::arg("name"), py::arg("u") = py::none());
  Material::for_fields([&](const FieldInfo& field, auto member) {
    if constexpr (Described<MemberType<decltype(member)>>)
      MemberType<decltype(member)>::for_fields([&](const FieldInfo& part, auto of_part) {
        material.def_property_readonly(part.name, [=](const Material& self) {
          const auto& value = self.*member.*of_part;
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, Vec3>)
            return three(value);
          else
            return value;
        });
      });
    else
      material.def_readonly(field.name, member);
  });
  material.def("__repr__",
               [](const Material& self) { return "<kibori.Material " + self.name + ">"; });
  module.def(
      "known_materials", [] { return known_materials(); }, "The materials that are known by name.");
}

}  // namespace kibori::python
