// SPDX-License-Identifier: MIT
// Converts a stock's description in a document to JSON and back. Checks everything that it reads.
// docs/documents.md describes the format. Internal: not installed.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/material.h>
#include <kibori/scene/stock.h>

namespace kibori {

// `label`: of the start of the first move; may be empty.
std::string stock_to_json(const Stock& stock, const std::string& label,
                          const std::vector<Material>& materials);
// For a model without a stock description: it cannot be made again.
std::string stock_to_json(const std::vector<Material>& materials);

// The stock's file is only its original name. Errors: the text does not describe the stock.
Result<Stock> stock_from_json(const std::string& text);
// Empty if the text has none.
std::string stock_label(const std::string& text);
std::vector<Material> stock_materials(const std::string& text);

}  // namespace kibori
