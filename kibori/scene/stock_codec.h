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

// `label`: that of the scene's first move; may be empty.
std::string stock_to_json(const Stock& stock, const std::string& label,
                          const std::vector<Material>& materials);
// For a model without a stock description. Such a model cannot be made again at another pitch.
std::string stock_to_json(const std::vector<Material>& materials);

// The path of the stock's file is only the name of the original file. The document holds its
// content. Errors: the text does not describe a stock.
Result<Stock> stock_from_json(const std::string& text);
// The label and the materials in the JSON; empty if it has none.
std::string stock_label(const std::string& text);
std::vector<Material> stock_materials(const std::string& text);

}  // namespace kibori
