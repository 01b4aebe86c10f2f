// SPDX-License-Identifier: MIT
// Numbers and places in JSON that is not to be trusted. Internal to `document`.
#pragma once

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include <kibori/geometry/vec.h>

namespace kibori {

using Json = nlohmann::json;

inline Json vec(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline bool read_vec(const Json& json, Vec3& v) {
  if (!json.is_array() || json.size() != 3) return false;
  for (size_t i = 0; i < 3; i++) {
    if (!json[i].is_number()) return false;
    v[static_cast<int>(i)] = json[i].get<double>();
  }
  return v.allFinite();
}

// Numbers of a JSON object; the first that is missing or none is remembered.
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
  void get(const char* key, Vec3& value) {
    const Json* found = find(key);
    if (!found) return;
    if (!read_vec(*found, value) && wrong.empty())
      wrong = std::string(key) + " is not a vector of three numbers";
  }
};

}  // namespace kibori
