// SPDX-License-Identifier: MIT
// Reads and checks the values of one table of a scene, by key. Only the first error is kept. After
// an error, the values that are read have no meaning. Internal: not installed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <toml++/toml.h>

#include <kibori/base/field_info.h>
#include <kibori/base/names.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// Returns the known word that is nearest to `word`, for "did you mean".
std::string nearest(std::string_view word, const std::vector<std::string>& known);
std::vector<std::string> strings(const auto& names) { return {names.begin(), names.end()}; }

// The first error of a scene, with file and line.
class SceneError {
 public:
  explicit SceneError(std::string file) : file_(std::move(file)) {}
  void report(int line, const std::string& what);  // line 0: without a line
  void report_sentence(const std::string& sentence);
  bool found() const { return !sentence_.empty(); }
  const std::string& sentence() const { return sentence_; }

 private:
  std::string file_, sentence_;
};

class TableReader {
 public:
  // `name` is the table's name in messages. It is empty for the root of the scene.
  TableReader(SceneError& error, const toml::table& table, std::string name)
      : error_(error), table_(table), name_(std::move(name)) {}

  const std::string& name() const { return name_; }
  const toml::node* find(std::string_view key) const { return table_.get(key); }
  bool has(std::string_view key) const { return table_.contains(key); }
  // Return the line of the table, or of one of its keys. If the key is missing: the line of the
  // table.
  int line() const { return line_of(table_); }
  int line(std::string_view key) const;
  static int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

  // Returns the table's name with `text`, for messages: "[stock] pitch".
  std::string full(std::string_view text) const;
  SceneError& error() const { return error_; }
  bool failed() const { return error_.found(); }
  void fail(int line, const std::string& what) const { error_.report(line, what); }
  void fail(std::string_view key, const std::string& what) const { fail(line(key), what); }
  void fail(const std::string& what) const { fail(line(), what); }

  // Reports an error for each key that is not in `known`. The message suggests the nearest known
  // key.
  void only(const std::vector<std::string>& known) const;

  // Read required values. A missing value is an error.
  double number(std::string_view key) const;
  double positive(std::string_view key) const;
  std::string text(std::string_view key) const;
  std::vector<double> numbers(std::string_view key, size_t count) const;
  Vec3 vector(std::string_view key) const;
  std::vector<Vec3> places(std::string_view key) const;
  // Read optional values. If the value is missing, `otherwise` is returned, or `value` stays.
  double number_or(std::string_view key, double otherwise) const;
  bool flag_or(std::string_view key, bool otherwise) const;
  void not_negative(std::string_view key, double& value) const;
  // Reads a required value: a list of three numbers, or one number for all three.
  void one_or_three(std::string_view key, std::array<double, 3>& value) const;
  // Read optional values. If the value is missing, `value` stays.
  void color(std::string_view key, std::array<uint8_t, 3>& value) const;
  template <Named E>
  void choice(std::string_view key, E& value, const std::string& one_of = listed<E>()) const {
    if (!has(key)) return;
    if (const auto known = value_of<E>(text(key)))
      value = *known;
    else
      fail(key, full(key) + " must be " + one_of);
  }

  // keys_of() returns the keys of a struct that describes its members (Described). fields() reads
  // the values of the keys that the table has. The caller reads nested tables and special cases.
  template <Described T>
  static std::vector<std::string> keys_of() {
    std::vector<std::string> keys;
    T::for_fields([&](const FieldInfo& field, auto) { keys.emplace_back(field.name); });
    return keys;
  }
  template <Described T>
  void fields(T& into) const {
    T::for_fields([&](const FieldInfo& field, auto member) { value(field, into.*member); });
  }

  // Returns the nested table `key`, or nothing if there is none. If the value is not a table, also
  // reports an error. `example` is a correct table for the message.
  std::optional<TableReader> table(std::string_view key, const std::string& example) const;
  // Returns the table [key] of the root, or nothing if there is none. Reports an error if the value
  // is not a table, or if `required` is true and the table is missing.
  std::optional<TableReader> section(std::string_view key, bool required) const;
  // Calls f for each table [[key]] of the root, until the first error. `otherwise` is the message
  // if the value is not a list of tables.
  template <class F>
  void for_tables(std::string_view key, const std::string& otherwise, F&& f) const {
    const toml::array* const list = tables(key, otherwise);
    if (!list) return;
    for (const toml::node& element : *list) {
      f(TableReader(error_, *element.as_table(), std::string(key)));
      if (failed()) return;
    }
  }

 private:
  template <class Value>
  void value(const FieldInfo& field, Value& into) const {
    const char* const key = field.name;
    if (Described<Value> || !has(key)) return;
    if constexpr (std::is_same_v<Value, double>)
      number_in(field, into);
    else if constexpr (Named<Value>)
      choice(key, into);
    else if constexpr (std::is_same_v<Value, bool>)
      into = flag_or(key, into);
    else if constexpr (std::is_same_v<Value, std::string>)
      into = text(key);
    else if constexpr (std::is_same_v<Value, Vec3>)
      into = vector(key);
    else if constexpr (std::is_same_v<Value, std::array<double, 3>>)
      one_or_three(key, into);
    else if constexpr (!Described<Value>)
      color(key, into);
  }
  void number_in(const FieldInfo& field, double& into) const;
  const toml::array* tables(std::string_view key, const std::string& otherwise) const;
  double as_number(const toml::node& node, const std::string& what) const;
  // Returns the names in quotes, for messages: "smooth", "linear" or "constant".
  template <Named E>
  static std::string listed() {
    return listed(strings(names_of(E{})));
  }
  static std::string listed(const std::vector<std::string>& names);

  SceneError& error_;
  const toml::table& table_;
  std::string name_;
};

}  // namespace kibori
