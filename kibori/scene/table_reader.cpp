// SPDX-License-Identifier: MIT
#include <kibori/scene/table_reader.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <kibori/base/file.h>

namespace kibori {
namespace {

// Levenshtein distance.
size_t distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); j++) row[j] = j;
  for (size_t i = 1; i <= a.size(); i++) {
    size_t diagonal = row[0]++;
    for (size_t j = 1; j <= b.size(); j++) {
      const size_t next =
          std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1] ? 1u : 0u)});
      diagonal = std::exchange(row[j], next);
    }
  }
  return row[b.size()];
}

}  // namespace

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = static_cast<size_t>(-1);
  for (const std::string& k : known)
    if (const size_t d = distance(word, k); d < best_distance) {
      best_distance = d;
      best = k;
    }
  return best;
}

void SceneError::report(int line, const std::string& what) {
  std::string sentence = file_;
  if (line > 0) sentence.append(":").append(std::to_string(line));
  report_sentence(sanitize_message(sentence.append(": ").append(what)));
}

void SceneError::report_sentence(const std::string& sentence) {
  if (sentence_.empty()) sentence_ = sentence;
}

int TableReader::line(std::string_view key) const {
  const toml::node* const node = find(key);
  return node ? line_of(*node) : line();
}

std::string TableReader::full(std::string_view text) const {
  return name_.empty() ? std::string(text) : "[" + name_ + "] " + std::string(text);
}

void TableReader::only(const std::vector<std::string>& known) const {
  for (const auto& [key, node] : table_)
    if (std::find(known.begin(), known.end(), key.str()) == known.end())
      fail(static_cast<int>(key.source().begin.line),
           "unknown key '" + std::string(key.str()) + "'" +
               (name_.empty() ? "" : " in [" + name_ + "]") + "; did you mean '" +
               nearest(key.str(), known) + "'?");
}

double TableReader::as_number(const toml::node& node, const std::string& what) const {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (value && std::isfinite(*value)) return *value;
  fail(line_of(node), what + " must be a finite number");
  return 1;
}

double TableReader::number(std::string_view key) const {
  if (const toml::node* const node = find(key)) return as_number(*node, full(key));
  fail(full(key) + " is missing");
  return 1;
}

double TableReader::number_or(std::string_view key, double otherwise) const {
  return has(key) ? number(key) : otherwise;
}

double TableReader::positive(std::string_view key) const {
  const double value = number(key);
  if (!(value > 0)) fail(key, full(key) + " must be greater than 0");
  return value;
}

void TableReader::not_negative(std::string_view key, double& value) const {
  if (!has(key)) return;
  value = number(key);
  if (!(value >= 0)) fail(key, full(key) + " must not be negative");
}

void TableReader::number_in(const FieldInfo& field, double& into) const {
  if (field.range == FieldRange::not_negative)
    not_negative(field.name, into);
  else
    into = field.range == FieldRange::positive ? positive(field.name) : number(field.name);
}

std::string TableReader::text(std::string_view key) const {
  const toml::node* const node = find(key);
  const auto value = node ? node->value_exact<std::string>() : std::nullopt;
  if (!node)
    fail(full(key) + " is missing");
  else if (!value)
    fail(key, full(key) + " must be a string");
  return value.value_or(std::string());
}

std::vector<double> TableReader::numbers(std::string_view key, size_t count) const {
  const toml::node* const node = find(key);
  const toml::array* const array = node ? node->as_array() : nullptr;
  if (!array || array->size() != count) {
    fail(key, full(key) + " must be a list of " + std::to_string(count) + " numbers");
    return std::vector<double>(count, 1);
  }
  std::vector<double> result;
  for (const toml::node& element : *array) result.push_back(as_number(element, full(key)));
  return result;
}

void TableReader::one_or_three(std::string_view key, std::array<double, 3>& value) const {
  const toml::node* const node = find(key);
  if (node && node->is_number()) {
    value.fill(number(key));
    return;
  }
  const std::vector<double> three = numbers(key, 3);
  std::copy(three.begin(), three.end(), value.begin());
}

Vec3 TableReader::vector(std::string_view key) const {
  const auto v = numbers(key, 3);
  return {v[0], v[1], v[2]};
}

std::vector<Vec3> TableReader::places(std::string_view key) const {
  std::vector<Vec3> all;
  const std::string wrong = full(key) + " must be a list of points [x, y, z]";
  const toml::node* const node = find(key);
  const toml::array* const list = node ? node->as_array() : nullptr;
  if (!list) {
    fail(key, wrong);
    return all;
  }
  for (const toml::node& item : *list) {
    const toml::array* const place = item.as_array();
    if (!place || place->size() != 3) {
      fail(line_of(item), wrong);
      return all;
    }
    all.emplace_back();
    for (size_t i = 0; i < 3; i++)
      all.back()[static_cast<int>(i)] = as_number(*place->get(i), "a place of " + full(key));
  }
  return all;
}

bool TableReader::flag_or(std::string_view key, bool otherwise) const {
  const toml::node* const node = find(key);
  if (!node) return otherwise;
  if (!node->is_boolean()) fail(key, full(key) + " must be true or false");
  return node->value_or(otherwise);
}

void TableReader::color(std::string_view key, std::array<uint8_t, 3>& value) const {
  if (!has(key)) return;
  const std::string written = text(key);
  unsigned rgb = 0;
  char rest = 0;
  const bool hex = written.size() == 7 &&
                   written.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (!hex || std::sscanf(written.c_str(), "#%6x%c", &rgb, &rest) != 1)
    return fail(key, full(key) + " must look like \"#c49a6c\"");
  value = {static_cast<uint8_t>(rgb >> 16), static_cast<uint8_t>(rgb >> 8),
           static_cast<uint8_t>(rgb)};
}

std::optional<TableReader> TableReader::table(std::string_view key,
                                              const std::string& example) const {
  const toml::node* const node = find(key);
  if (!node) return std::nullopt;
  if (const toml::table* const table = node->as_table())
    return TableReader(error_, *table, std::string(key));
  fail(key, full(key) + " must be a table, as in " + example);
  return std::nullopt;
}

std::optional<TableReader> TableReader::section(std::string_view key, bool required) const {
  const toml::node* const node = find(key);
  if (!node) {
    if (required) fail(0, std::string("[").append(key).append("] is missing"));
    return std::nullopt;
  }
  if (const toml::table* const table = node->as_table())
    return TableReader(error_, *table, std::string(key));
  fail(key, std::string("[").append(key).append("] must be a table"));
  return std::nullopt;
}

const toml::array* TableReader::tables(std::string_view key, const std::string& otherwise) const {
  const toml::node* const node = find(key);
  if (!node) return nullptr;
  const toml::array* const list = node->as_array();
  if (list && list->is_homogeneous(toml::node_type::table)) return list;
  fail(key, otherwise);
  return nullptr;
}

std::string TableReader::listed(const std::vector<std::string>& names) {
  std::string list;
  for (size_t i = 0; i < names.size(); i++)
    list += (i == 0 ? "\"" : i + 1 < names.size() ? ", \"" : " or \"") + names[i] + "\"";
  return list;
}

}  // namespace kibori
