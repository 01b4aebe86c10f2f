// SPDX-License-Identifier: MIT
// The actions on the bodies of a document. A BodyAction has a verb, and the ids of the bodies that
// the action names. Each verb is a struct with its data.
//
// A new verb needs:
// - a struct here and an entry in BodyVerb,
// - its effect in bodies.cpp,
// - its JSON in document/body_codec.cpp,
// - its label in the studio.
//
// If one of these is missing, the code does not compile.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <kibori/body/cutter.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>
#include <kibori/spline/apply_spline.h>

namespace kibori {

using BodyId = int;
inline constexpr size_t kMaxPathPoints = 4096;

// What a verb requires of the bodies that the action names.
struct BodyRule {
  enum class Changes { none, first, all };
  size_t fewest = 1;               // minimum number of bodies
  Changes changes = Changes::all;  // bodies that it changes: they must not be locked or protected
  bool of_no_go = false;           // true: it may change protected bodies, too
  bool places = false;             // true: it moves bodies, together with their masks
};

// Properties of a body. An action sets only those that have a value.
struct BodyProperties {
  std::optional<std::string> name = {};
  std::optional<bool> visible = {}, locked = {}, no_go = {};
};

// Cuts the bodies with the cutter, which is in world coordinates. If no body is named, it cuts all
// visible bodies that are neither locked nor protected.
struct BodyCut {
  static constexpr const char* kVerb = "cut";
  static constexpr BodyRule kRule{0};
  Cutter cutter = {};
};

// Moves the material of the other bodies into the first one.
struct BodyJoin {
  static constexpr const char* kVerb = "join";
  static constexpr BodyRule kRule{2};
};

// Cuts the other bodies out of the first one. The others stay.
struct BodySubtract {
  static constexpr const char* kVerb = "subtract";
  static constexpr BodyRule kRule{2, BodyRule::Changes::first};
};

// Reduces the first body to the material that all other bodies contain, too. The others stay.
struct BodyIntersect {
  static constexpr const char* kVerb = "intersect";
  static constexpr BodyRule kRule{2, BodyRule::Changes::first};
};

// Divides each body into its connected pieces. The largest piece stays, and each other piece
// becomes a new body.
struct BodySeparate {
  static constexpr const char* kVerb = "separate";
  static constexpr BodyRule kRule{};
};

// Copies each body, in the same place. The copies are neither locked nor protected.
struct BodyDuplicate {
  static constexpr const char* kVerb = "duplicate";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
};

// Mirrors the bodies in a plane, which is in world coordinates.
struct BodyMirror {
  static constexpr const char* kVerb = "mirror";
  static constexpr BodyRule kRule{.places = true};
  CutPlane plane = {};
};

// Moves each body to this pose.
struct BodyMove {
  static constexpr const char* kVerb = "move";
  static constexpr BodyRule kRule{.of_no_go = true, .places = true};
  Pose pose = {};
};

// Sets each body's pose to the identity. Its model is converted, so that its surface stays in
// place.
struct BodyBake {
  static constexpr const char* kVerb = "bake";
  static constexpr BodyRule kRule{.of_no_go = true, .places = true};
};

// Removes bodies from the list.
struct BodyRemove {
  static constexpr const char* kVerb = "remove";
  static constexpr BodyRule kRule{.of_no_go = true};
};

// Changes the name, the visibility, the lock or the protection of bodies.
struct BodySet {
  static constexpr const char* kVerb = "set";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
  BodyProperties properties = {};
};

// Adds a body that fills the volume of `tool` at `pose`. The action must not name a body. The new
// body is never locked.
struct BodyAdd {
  static constexpr const char* kVerb = "add";
  static constexpr BodyRule kRule{0};
  Tool tool = BallTool{};
  Pose pose = {};
  uint8_t material = 0;
  BodyProperties properties = {};
};

// Protects the part of the first body that `tool` covers along its path. This part becomes a new
// mask, which is a protected body. If a second body is named, it must be a mask, and the part is
// added to it.
struct BodyProtect {
  static constexpr const char* kVerb = "protect";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
  Tool tool = BallTool{};
  std::vector<Vec3> path_mm = {};                        // path of the upright tool's tip, world
  SplineOperation operation = SplineOperation::deposit;  // cut: removes the part from the mask
  bool follows = true;             // true: a new mask moves, turns and mirrors with the first body
  BodyProperties properties = {};  // of a new mask: its name
};

// Adds a spline's shape to a body, cuts the shape out of it, or keeps only what is inside the
// shape.
struct BodySpline {
  static constexpr const char* kVerb = "spline";
  static constexpr BodyRule kRule{};
  SplineShape shape = {};  // in world coordinates
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
};

// All verbs. This is the only list.
using BodyVerb = std::variant<BodyCut, BodyJoin, BodySubtract, BodyIntersect, BodySeparate,
                              BodyDuplicate, BodyMirror, BodyMove, BodyBake, BodyRemove, BodySet,
                              BodyAdd, BodyProtect, BodySpline>;

namespace internal {
template <class... Verb>
constexpr std::array<std::string_view, sizeof...(Verb)> verbs_of(
    std::type_identity<std::variant<Verb...>>) {
  return {Verb::kVerb...};
}
}  // namespace internal

// The names of all verbs, in the order of BodyVerb. Documents and messages use them.
inline constexpr auto kBodyVerbs = internal::verbs_of(std::type_identity<BodyVerb>());

// One action: a verb, and the bodies that it names.
struct BodyAction {
  std::vector<BodyId> bodies;
  BodyVerb verb;
};

// The name of an action's verb.
inline std::string_view verb_of(const BodyAction& action) {
  return kBodyVerbs[action.verb.index()];
}
// Returns the verb with this name, with default data; nullopt if the name is unknown.
std::optional<BodyVerb> default_verb(std::string_view name);

}  // namespace kibori
