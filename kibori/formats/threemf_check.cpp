// SPDX-License-Identifier: MIT
#include <kibori/formats/threemf_check.h>

#include <algorithm>
#include <array>
#include <cstring>

#include <kibori/formats/text.h>

namespace kibori {
namespace {

struct Needed {
  std::string_view element;
  const char* attribute;
};
constexpr Needed kNeeded[] = {{"base", "name"},
                              {"base", "displaycolor"},
                              {"color", "color"},
                              {"compositematerials", "matid"},
                              {"compositematerials", "matindices"},
                              {"metadata", "name"},
                              {"multiproperties", "pids"},
                              {"texture2d", "path"},
                              {"texture2d", "contenttype"},
                              {"texture2dgroup", "texid"}};
constexpr std::array<std::string_view, 6> kMaterials = {"basematerials",      "colorgroup",
                                                        "texture2d",          "texture2dgroup",
                                                        "compositematerials", "multiproperties"};

template <size_t N>
bool is_one_of(std::string_view word, const std::array<std::string_view, N>& words) {
  return std::ranges::find(words, word) != words.end();
}

// The value of an attribute; null if there is none.
const char* find(const char* const* attributes, const char* name) {
  for (; *attributes; attributes += 2)
    if (std::strcmp(*attributes, name) == 0) return attributes[1];
  return nullptr;
}

}  // namespace

std::string ThreeMfCheck::kind_of(std::string_view id) const {
  const auto found = resources_.find(id);
  return found == resources_.end() ? std::string() : found->second;
}

void ThreeMfCheck::open(std::string_view element, const char* const* attributes) {
  // Most elements are vertices, which are not checked.
  if (element == "vertex") return;
  if (element == "triangle") {
    if (in_object_ && !object_has_pid_ && find(attributes, "p1") && !find(attributes, "pid"))
      note_("a triangle has a material without its group; the shape is not affected");
    return;
  }
  for (const Needed& needed : kNeeded)
    if (element == needed.element && !find(attributes, needed.attribute))
      note_("an element " + in_quotes(element) + " has no attribute " +
            in_quotes(needed.attribute) + "; the shape is not affected");
  if (const char* name = find(attributes, "name");
      element == "metadata" && name && !in_object_ && !metadata_.insert(name).second)
    note_("metadata " + in_quotes(name) + " occurs twice");
  if (find(attributes, "xml:space")) note_("an element has the attribute 'xml:space'");
  resources_seen_ = resources_seen_ || element == "resources";
  build_seen_ = build_seen_ || element == "build";
  if (element == "object") check_object(attributes);
  if (element == "build") in_object_ = false;
  if (is_one_of(element, kMaterials)) {
    in_object_ = false;
    check_references(element, attributes);
    if (const char* id = find(attributes, "id")) check_resource(element, id);
  }
}

void ThreeMfCheck::check_resource(std::string_view element, const std::string& id) {
  if (!resources_.try_emplace(id, element).second)
    note_("two resources have the id " + in_quotes(id) + "; the shape is not affected");
}

void ThreeMfCheck::check_object(const char* const* attributes) {
  in_object_ = true;
  object_has_pid_ = find(attributes, "pid") != nullptr;
  constexpr std::array<std::string_view, 5> kTypes = {"model", "solidsupport", "support", "surface",
                                                      "other"};
  if (const char* type = find(attributes, "type"); type && !is_one_of(type, kTypes))
    note_("an object has the unknown type " + in_quotes(type) + " and is read as a model");
  if (!object_has_pid_ && find(attributes, "pindex"))
    note_("an object has a material without its group; the shape is not affected");
  if (const char* id = find(attributes, "id")) check_resource("object", id);
}

void ThreeMfCheck::check_references(std::string_view element, const char* const* attributes) {
  if (const char* base = find(attributes, "matid");
      element == "compositematerials" && base && kind_of(base) != "basematerials")
    note_("composite materials are mixed from " + in_quotes(base) +
          ", which are not base materials; the shape is not affected");
  if (const char* type = find(attributes, "contenttype"); element == "texture2d" && type &&
                                                          std::strcmp(type, "image/png") != 0 &&
                                                          std::strcmp(type, "image/jpeg") != 0)
    note_("a texture has the unknown type " + in_quotes(type) + "; the shape is not affected");
  const char* all = find(attributes, "pids");
  if (element != "multiproperties" || !all) return;
  int materials = 0, colors = 0, multiple = 0;
  std::string_view left(all);
  for (std::string_view id = take_word(left); !id.empty(); id = take_word(left)) {
    const std::string kind = kind_of(id);
    materials += kind == "basematerials" || kind == "compositematerials";
    colors += kind == "colorgroup";
    multiple += kind == "multiproperties";
  }
  if (materials > 1 || colors > 1 || multiple > 0)
    note_(
        "multiple properties combine groups that must not be combined; the shape is not affected");
}

void ThreeMfCheck::found_undeclared(const std::string& prefix) {
  constexpr size_t kMaxNotes = 8;
  if (undeclared_.size() < kMaxNotes && undeclared_.insert(prefix).second)
    note_("the prefix " + in_quotes(prefix) + " is used, but not declared");
}

void ThreeMfCheck::finish() const {
  if (!resources_seen_) note_("the model has no element 'resources'");
  if (!build_seen_) note_("the model has no element 'build'");
}

}  // namespace kibori
