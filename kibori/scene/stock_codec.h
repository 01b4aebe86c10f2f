// SPDX-License-Identifier: MIT
// Converts the description of a stock to JSON and back, for documents. docs/documents.md describes
// the format. Internal: not installed.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/material.h>
#include <kibori/scene/stock.h>

namespace kibori {

// Returns the description of a stock as JSON. `label` is that of the scene's first move; it may be
// empty.
std::string stock_to_json(const Stock& stock, const std::string& label,
                          const std::vector<Material>& materials);
// Returns the JSON for a model without a description. Such a model cannot be made again at another
// pitch.
std::string stock_to_json(const std::vector<Material>& materials);

// Reads a description. The path of its file is only the name of the original file, because the
// document has the content. Errors: the text does not describe a stock.
Result<Stock> stock_from_json(const std::string& text);
// Return the label and the materials of the JSON. Empty if it has none.
std::string stock_label(const std::string& text);
std::vector<Material> stock_materials(const std::string& text);

}  // namespace kibori
