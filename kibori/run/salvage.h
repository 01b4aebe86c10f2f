// SPDX-License-Identifier: MIT
// Saves what is whole of a damaged document.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/document/document.h>

namespace kibori {

// Carves what is whole on the way to a document's head again, as a new one, with forces and
// versions; without pictures. Up to which step: the last whose stroke, and all before it, are
// whole. Errors: the path; not even the stock is whole.
Result<StepId> salvage(const Document& document, const std::filesystem::path& into);
}  // namespace kibori
