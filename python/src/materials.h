// SPDX-License-Identifier: MIT
// Finds materials by name or by their properties.
#pragma once

#include <optional>
#include <string>
#include <variant>

#include <kibori/run/workpiece.h>
#include <kibori/geometry/material.h>

#include "python/src/conversions.h"

namespace kibori::python {

using MaterialOrName = std::variant<Material, std::string>;

// Errors: no material has this name.
Material material_named(const MaterialOrName& wanted);
// The material's index in the piece's list. Adds it if it is missing. Without a wanted material,
// returns the first one.
uint8_t number_of(Workpiece& piece, const std::optional<MaterialOrName>& wanted);

void bind_materials(py::module_& module);

}  // namespace kibori::python
