// SPDX-License-Identifier: MIT
// Saves a document elsewhere if its file is not writable, and removes documents.
#pragma once

#include <filesystem>
#include <string>

#include <kibori/document/document.h>

namespace kibori {

// If some of a session could not be written, saves the whole document. It tries the document's own
// file first. Then it tries the temporary folder, the home folder, the current folder, and
// /var/tmp. Returns a sentence with the new location; empty if the document's own file is complete.
std::string settle(Document& document);

// Removes the file of a closed document, and the files that SQLite may have left next to it.
void remove_document(const std::filesystem::path& path);

}  // namespace kibori
