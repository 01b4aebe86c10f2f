// SPDX-License-Identifier: MIT
// Where a document goes that can't be written where it belongs, and how its file is removed.
#pragma once

#include <filesystem>
#include <string>

#include <kibori/document/document.h>

namespace kibori {

// Saves what could not be saved while it was made: where it belongs, or else into the temporary
// folder or, where that is full, too, the home folder, the current one or /var/tmp. A sentence on
// where it is; empty if all is where it belongs.
std::string settle(Document& document);

// Removes the file of a document that is not open, and what SQLite may have left beside it.
void remove_document(const std::filesystem::path& path);

}  // namespace kibori
