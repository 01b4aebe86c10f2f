// SPDX-License-Identifier: MIT
// Converts bodies, and actions on bodies, to JSON and back. Documents and the studio's messages use
// this JSON. The functions check everything that they read. docs/documents.md describes the format.
// Internal: not installed.
#pragma once

#include <string>

#include <kibori/base/result.h>
#include <kibori/body/bodies.h>

namespace kibori {

// Convert an action to JSON and back. Errors: the text is not JSON, or not a valid action.
std::string action_to_json(const BodyAction& action);
Result<BodyAction> action_from_json(const std::string& text);

// Convert the ids, names, poses and flags of bodies. Models are stored separately, as tiles.
// Errors: the text is not JSON, or not a valid list of bodies.
std::string bodies_to_json(const BodyList& bodies);
Result<BodyList> bodies_from_json(const std::string& text);

}  // namespace kibori
