// SPDX-License-Identifier: MIT
// Converts bodies and the actions on them to JSON and back, for documents and the studio's
// messages. Everything that is read is checked. docs/documents.md describes the format. Internal:
// not installed.
#pragma once

#include <string>

#include <kibori/base/result.h>
#include <kibori/body/bodies.h>

namespace kibori {

// An action as JSON. Errors: text that is not JSON, or not a valid action.
std::string action_to_json(const BodyAction& action);
Result<BodyAction> action_from_json(const std::string& text);

// Ids, names, poses, and flags. The models are stored as tiles.
std::string bodies_to_json(const BodyList& bodies);
Result<BodyList> bodies_from_json(const std::string& text);

}  // namespace kibori
