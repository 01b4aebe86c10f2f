// SPDX-License-Identifier: MIT
// Materials by name or by their numbers.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include <kibori/run/workpiece.h>
#include <kibori/geometry/material.h>

#include "python/src/conversions.h"

namespace kibori::python {

using MaterialOrName = std::variant<Material, std::string>;

// Errors: no material is called so.
Material material_named(const MaterialOrName& wanted);
// Its number in the piece's list, where it is put if it is not there; the first where none is
// wanted.
uint8_t number_of(Workpiece& piece, const std::optional<MaterialOrName>& wanted);

void bind_materials(py::module_& module);

}  // namespace kibori::python
