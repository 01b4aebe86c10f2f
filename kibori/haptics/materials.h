// SPDX-License-Identifier: MIT
// The built-in materials and their physics. Scenes, documents and the studio share this table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <kibori/haptics/force.h>

namespace kibori {

// All built-in materials, in the order in which the user interface lists them; never empty.
const std::vector<Material>& known_materials();
// The built-in material of that name; null if there is none.
const Material* known_material(std::string_view name);
// The law of its forces in one line: "33 / 10 / 7 N/mm^1.5" (end grain, along, across) or "2
// N/mm²".
std::string law_text(const Material& material);

}  // namespace kibori
