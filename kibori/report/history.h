// SPDX-License-Identifier: MIT
// Prints the history of a document as text and as JSON.
#pragma once

#include <string>

#include <kibori/document/document.h>

namespace kibori {

// Return the steps and versions. The text has one line for each, and marks the head.
std::string history_text(const Document& document);
std::string history_json(const Document& document);

}  // namespace kibori
