// SPDX-License-Identifier: MIT
// Carves the steps of a document again into a new document: to save a damaged document, or to
// change the pitch.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/run/carving.h>

namespace kibori {

// Carves the steps on the path to a document's head into a new document. Stops at the first step
// that does not give its recorded state. Does not check seals. Keeps forces and versions, but not
// pictures. Returns the last saved step. Errors: the path is invalid; not even the stock is
// undamaged; the new document cannot be written.
Result<StepId> salvage(const Document& document, const std::filesystem::path& into);

// Carves the steps on the path to a document's head at another pitch into a new document. Keeps
// poses, tools and versions, but not forces and pictures. Returns the last step of the new
// document. Errors: the document is damaged; the stock or a step is not possible at this pitch; the
// new document cannot be written. After an error in a step, there is no new document.
Result<StepId> carve_again(const Document& document, const std::filesystem::path& into,
                           double pitch_mm, const CarveOptions& options);

}  // namespace kibori
