// SPDX-License-Identifier: MIT
// Saves the steps of a damaged document that can be carved again.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/document/document.h>

namespace kibori {

// Carves the steps on the path to a document's head again, into a new document. It stops at the
// first step that cannot be carved to its recorded state. Rows that do not match their seals are
// used. It keeps forces and versions, but not pictures. Returns the last saved step. Errors: an
// invalid path, or not even the stock is intact.
Result<StepId> salvage(const Document& document, const std::filesystem::path& into);

}  // namespace kibori
