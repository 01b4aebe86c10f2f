// SPDX-License-Identifier: MIT
// Scenes that come with the program, to be carved or watched.
#pragma once

#include <string>
#include <vector>

namespace kibori::studio {

struct Example {
  std::string name, about, scene;  // `about`: a few words; `scene`: its text
};
const std::vector<Example>& examples();

}  // namespace kibori::studio
