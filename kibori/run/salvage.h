// SPDX-License-Identifier: MIT
// Carves the steps of a document again, into a new document: to save a damaged document, or to
// change the pitch.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/run/carving.h>

namespace kibori {

// Carves the steps on the path to a document's head again, into a new document. It stops at the
// first step that does not result in its recorded state. Seals are not checked. It keeps forces and
// versions, but not pictures. Returns the last saved step. Errors: an invalid path; not even the
// stock is intact; the new document cannot be written.
Result<StepId> salvage(const Document& document, const std::filesystem::path& into);

// Carves the steps on the path to a document's head again at another pitch, into a new document.
// It keeps poses, tools and versions, but not forces and pictures. Returns the last step. Errors: a
// damaged document; a stock that cannot be made at this pitch; a step that cannot be carved at it.
// Such an error leaves no new document. Also an error: the new document cannot be written.
Result<StepId> carve_again(const Document& document, const std::filesystem::path& into,
                           double pitch_mm, const CarveOptions& options);

}  // namespace kibori
