// SPDX-License-Identifier: MIT
// The history of a document as text and as JSON.
#pragma once

#include <string>

#include <kibori/document/document.h>

namespace kibori {

// The steps and versions, one per line. The head is marked.
std::string history_text(const Document& document);
std::string history_json(const Document& document);

}  // namespace kibori
