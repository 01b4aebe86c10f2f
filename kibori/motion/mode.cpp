// SPDX-License-Identifier: MIT
#include <kibori/motion/mode.h>

#include <string>

namespace kibori {

Status check_modes(Mode first, std::optional<Mode> second, bool protects) {
  const auto quoted = [](Mode mode) { return "mode \"" + std::string(name_of(mode)) + "\""; };
  if (protects && reshapes(first))
    return Error{quoted(first) +
                 " can't work next to a protected body; use cut, deposit or touch, or allow cuts "
                 "in that body first"};
  if (!second) return Ok{};
  if (reshapes(*second))
    return Error{quoted(*second) +
                 " is only for the first hand; the second hand can cut, deposit or touch"};
  if (reshapes(first) && kind_of(*second) == ModeKind::edit)
    return Error{quoted(first) +
                 " can't work together with a second hand that cuts or deposits; give the second "
                 "hand mode = \"off\""};
  return Ok{};
}

}  // namespace kibori
