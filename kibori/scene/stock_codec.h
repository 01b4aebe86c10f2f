// SPDX-License-Identifier: MIT
// What a document says of its stock, as JSON and back. Everything read is checked.
// docs/documents.md describes the form. Internal: not installed.
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
// Of a model that came otherwise: it can't be made again.
std::string stock_to_json(const std::vector<Material>& materials);

// Its file is the name that it had. Errors: it does not say how the stock was made.
Result<Stock> stock_from_json(const std::string& text);
// Empty where it does not say.
std::string stock_label(const std::string& text);
std::vector<Material> stock_materials(const std::string& text);

}  // namespace kibori
