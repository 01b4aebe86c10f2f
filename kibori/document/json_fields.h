// SPDX-License-Identifier: MIT
// Reads numbers and vectors from untrusted JSON. Converts described structs (base/field_info.h) to
// JSON and back. Internal to `document`.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

#include <kibori/base/field_info.h>
#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

inline Json vec(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline bool read_vec(const Json& json, Vec3& v) {
  if (!json.is_array() || json.size() != 3) return false;
  for (size_t i = 0; i < 3; i++) {
    if (!json[i].is_number()) return false;
    v[static_cast<int>(i)] = json[i].get<double>();
  }
  return v.allFinite();
}

// Reads the values of a JSON object. After the first missing or invalid value, `wrong` describes
// it.
struct Fields {
  const Json& json;
  std::string wrong = {};

  const Json* find(const char* key) {
    const auto found = json.find(key);
    if (found != json.end()) return &*found;
    if (wrong.empty()) wrong = std::string("has no ") + key;
    return nullptr;
  }
  void get(const char* key, double& value) {
    const Json* found = find(key);
    if (!found) return;
    if (found->is_number() && std::isfinite(found->get<double>()))
      value = found->get<double>();
    else if (wrong.empty())
      wrong = std::string(key) + " is not a number";
  }
  void get(const char* key, int& value, int min, int max) {
    double read = 0;
    get(key, read);
    if (wrong.empty() && !(read >= min && read <= max))
      wrong = std::string(key) + " is out of range";
    if (wrong.empty()) value = static_cast<int>(read);
  }
  void get(const char* key, std::string& value) {
    const Json* found = find(key);
    if (!found) return;
    if (found->is_string())
      value = found->get<std::string>();
    else if (wrong.empty())
      wrong = std::string(key) + " is not text";
  }
  void get(const char* key, std::array<double, 3>& value) {
    Vec3 vector;
    const Json* found = find(key);
    if (!found) return;
    if (read_vec(*found, vector))
      value = {vector.x(), vector.y(), vector.z()};
    else if (wrong.empty())
      wrong = std::string(key) + " is not a list of three numbers";
  }
  void get(const char* key, Vec3& value) {
    const Json* found = find(key);
    if (!found) return;
    if (!read_vec(*found, value) && wrong.empty())
      wrong = std::string(key) + " is not a vector of three numbers";
  }
};

using Rgb8 = std::array<uint8_t, 3>;

// Reads a colour. If the JSON has no valid colour, `color` stays.
inline void read_color(const Json& json, const char* key, Rgb8& color) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() != 3) return;
  for (size_t i = 0; i < 3; i++)
    if ((*found)[i].is_number_unsigned())
      color[i] = static_cast<uint8_t>((*found)[i].get<unsigned>());
}

// Returns the members of a described struct as JSON, except those with Stored::where_used.
template <Described T>
Json fields_to_json(const T& from) {
  Json json = Json::object();
  T::for_fields([&](const FieldInfo& field, auto member) {
    const auto& value = from.*member;
    using Value = std::decay_t<decltype(value)>;
    if (field.stored == Stored::where_used) return;
    if (field.stored == Stored::unless_default && value == T{}.*member) return;
    if constexpr (Described<Value>)
      json[field.key] = fields_to_json(value);
    else if constexpr (Named<Value>)
      json[field.key] = name_of(value);
    else if constexpr (std::is_same_v<Value, Vec3>)
      json[field.key] = vec(value);
    else
      json[field.key] = value;
  });
  return json;
}

// Reads the members of a described struct. Errors: a value is missing or invalid. The message
// begins with `what`: "the brush has no radius_mm".
template <Described T>
Status fields_from_json(const Json& json, const std::string& what, T& into) {
  Fields fields{json};
  std::string wrong;
  T::for_fields([&](const FieldInfo& field, auto member) {
    auto& value = into.*member;
    using Value = std::decay_t<decltype(value)>;
    const bool there = json.contains(field.key);
    if (field.stored == Stored::where_used || (field.stored != Stored::required && !there)) return;
    if constexpr (Described<Value>) {
      if (const Status read = fields_from_json(json.value(field.key, Json::object()),
                                               what + "'s " + field.key, value);
          !read && wrong.empty())
        wrong = read.error();
    } else if constexpr (Named<Value>) {
      std::string name;
      fields.get(field.key, name);
      const auto known = value_of<Value>(name);
      value = known.value_or(value);
      if (!known && fields.wrong.empty() && wrong.empty())
        wrong = std::string("no ") + field.key + " is called '" + sanitize_message(name) + "'";
    } else if constexpr (std::is_same_v<Value, bool>) {
      const Json* const found = fields.find(field.key);
      if (found && found->is_boolean())
        value = found->get<bool>();
      else if (found && wrong.empty())
        wrong = what + "'s " + field.key + " must be true or false";
    } else if constexpr (std::is_same_v<Value, Rgb8>) {
      read_color(json, field.key, value);
    } else {
      fields.get(field.key, value);
    }
    if (!fields.wrong.empty() && wrong.empty()) wrong = what + " " + fields.wrong;
  });
  return wrong.empty() ? Status(Ok{}) : Status(Error{wrong});
}

}  // namespace kibori
