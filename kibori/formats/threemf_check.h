// SPDX-License-Identifier: MIT
// Finds violations of the 3MF specification that do not affect the triangles. Files with such
// violations are read, and cause one note for each kind of violation. Internal to `formats`.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace kibori {

// Checks the elements of one model file of the archive.
class ThreeMfCheck {
 public:
  // `note` is called for each violation. It must outlive this object.
  explicit ThreeMfCheck(const std::function<void(const std::string&)>& note) : note_(note) {}

  // Call this for each element. `element` is its name without prefix. In `attributes`, names and
  // values alternate. The last pointer is null.
  void open(std::string_view element, const char* const* attributes);
  // Call this for each element whose prefix is not declared.
  void found_undeclared(const std::string& prefix);
  // Call this at the end of the model. It notes missing elements.
  void finish() const;

 private:
  void check_resource(std::string_view element, const std::string& id);
  void check_references(std::string_view element, const char* const* attributes);
  void check_object(const char* const* attributes);
  std::string kind_of(std::string_view id) const;

  const std::function<void(const std::string&)>& note_;
  std::map<std::string, std::string, std::less<>> resources_;  // name of the element for each id
  std::set<std::string> metadata_, undeclared_;
  bool resources_seen_ = false, build_seen_ = false, in_object_ = false;
  bool object_has_pid_ = false;
};

}  // namespace kibori
