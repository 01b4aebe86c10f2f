// SPDX-License-Identifier: MIT
// The scenes embedded in the program, to carve or to watch.
#pragma once

#include <string>
#include <vector>

namespace kibori::studio {

struct Example {
  std::string name, about, scene;  // `about`: a few words; `scene`: the TOML text
};
const std::vector<Example>& examples();

}  // namespace kibori::studio
