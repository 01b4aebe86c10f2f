// SPDX-License-Identifier: MIT
// Saves a document elsewhere if its file is not writable. Removes documents.
#pragma once

#include <filesystem>
#include <string>

#include <kibori/document/document.h>

namespace kibori {

// If the file lacks a part of the session (Document::unsaved), saves the whole document. Tries the
// document's own file first, then the temporary folder, the home folder, the current folder, and
// /var/tmp. Returns a sentence with the new location, or an empty text if the own file is complete.
// If all places fail, the sentence says that the rest is lost.
std::string settle(Document& document);

// Removes the file of a closed document, and the files that SQLite may have left next to the file.
void remove_document(const std::filesystem::path& path);

}  // namespace kibori
