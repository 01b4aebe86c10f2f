// SPDX-License-Identifier: MIT
// Bodies and what was done with them, as JSON and back: as documents hold it, and the studio's
// messages. Everything read is checked. docs/documents.md describes the form. Internal: not
// installed.
#pragma once

#include <string>

#include <kibori/base/result.h>
#include <kibori/body/bodies.h>

namespace kibori {

std::string action_to_json(const BodyAction& action);
Result<BodyAction> action_from_json(const std::string& text);

// Numbers, names, poses, and flags; the models are kept as tiles.
std::string bodies_to_json(const Bodies& bodies);
Result<Bodies> bodies_from_json(const std::string& text);

}  // namespace kibori
