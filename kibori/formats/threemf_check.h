// SPDX-License-Identifier: MIT
// Checks what the 3MF specification forbids but what does not affect the triangles. Such files are
// read, with a note. Internal to `formats`.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace kibori {

// Checks the elements of one model part.
class ThreeMfCheck {
 public:
  // `note` receives each fault. It must outlive this object.
  explicit ThreeMfCheck(const std::function<void(const std::string&)>& note) : note_(note) {}

  // Call this for each element, with its name without prefix. `attributes`: names and values in
  // alternation, ended by null.
  void open(std::string_view element, const char* const* attributes);
  void found_undeclared(const std::string& prefix);
  // The end of the model.
  void finish() const;

 private:
  void check_resource(std::string_view element, const std::string& id);
  void check_references(std::string_view element, const char* const* attributes);
  void check_object(const char* const* attributes);
  std::string kind_of(std::string_view id) const;

  const std::function<void(const std::string&)>& note_;
  std::map<std::string, std::string, std::less<>> resources_;  // ids, with their elements
  std::set<std::string> metadata_, undeclared_;
  bool resources_seen_ = false, build_seen_ = false, in_object_ = false;
  bool object_has_pid_ = false;
};

}  // namespace kibori
