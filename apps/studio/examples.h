// SPDX-License-Identifier: MIT
// The scenes that are embedded in the program. A user can carve or watch them.
#pragma once

#include <string>
#include <vector>

namespace kibori::studio {

struct Example {
  std::string name, about, scene;  // `about`: a few words; `scene`: the TOML text
};
const std::vector<Example>& examples();

}  // namespace kibori::studio
