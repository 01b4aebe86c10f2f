// SPDX-License-Identifier: MIT
// The built-in materials with their forces. Scenes, documents and the studio share this table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/haptics/force.h>

namespace kibori {

// Returns all built-in materials, in the order of the user interface. The list is never empty.
const std::vector<Material>& known_materials();
// Returns the built-in material with this name, or null if there is none.
const Material* known_material(std::string_view name);
// Returns the law of the material's forces in one line: "33 / 10 / 7 N/mm^1.5" (end grain, along,
// across) or "2 N/mm²".
std::string law_text(const Material& material);

}  // namespace kibori
