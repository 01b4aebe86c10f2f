// SPDX-License-Identifier: MIT
// What is done with the bodies of a document: a struct for each verb, with what it needs beyond the
// bodies that it names. Adding one: a struct here, a place in BodyVerb, and what it does in
// bodies.cpp, its JSON in document/body_codec.cpp and its label in the studio; without them nothing
// compiles.
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
inline constexpr size_t kMaxWayPoints = 4096;

// What a verb asks of the bodies that it names.
struct BodyRule {
  enum class Changes { none, first, all };
  size_t fewest = 1;
  Changes changes = Changes::all;  // a locked body, or one that is no-go, refuses it
  bool of_no_go = false;           // it may change a body that is no-go all the same
  bool places = false;             // masks go with their bodies
};

// Those that are given are set.
struct BodyProperties {
  std::optional<std::string> name = {};
  std::optional<bool> visible = {}, locked = {}, no_go = {};
};

// By the cutter, in world coordinates. Of no body: of all that can be changed.
struct BodyCut {
  static constexpr const char* kVerb = "cut";
  static constexpr BodyRule kRule{0};
  Cutter cutter = {};
};

// The others go into the first.
struct BodyJoin {
  static constexpr const char* kVerb = "join";
  static constexpr BodyRule kRule{2};
};

// The others are cut from the first, and stay.
struct BodySubtract {
  static constexpr const char* kVerb = "subtract";
  static constexpr BodyRule kRule{2, BodyRule::Changes::first};
};

// Of the first stays what lies in all others, which stay.
struct BodyIntersect {
  static constexpr const char* kVerb = "intersect";
  static constexpr BodyRule kRule{2, BodyRule::Changes::first};
};

// Each piece becomes a body; the largest stays.
struct BodySeparate {
  static constexpr const char* kVerb = "separate";
  static constexpr BodyRule kRule{};
};

// A copy of each, in the same place.
struct BodyDuplicate {
  static constexpr const char* kVerb = "duplicate";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
};

// In a plane, in world coordinates.
struct BodyMirror {
  static constexpr const char* kVerb = "mirror";
  static constexpr BodyRule kRule{.places = true};
  CutPlane plane = {};
};

// To a pose.
struct BodyMove {
  static constexpr const char* kVerb = "move";
  static constexpr BodyRule kRule{.of_no_go = true, .places = true};
  Pose pose = {};
};

// Its lattice stands as the world does, and its surface where it was.
struct BodyBake {
  static constexpr const char* kVerb = "bake";
  static constexpr BodyRule kRule{.of_no_go = true, .places = true};
};

// Of the list.
struct BodyRemove {
  static constexpr const char* kVerb = "remove";
  static constexpr BodyRule kRule{.of_no_go = true};
};

struct BodySet {
  static constexpr const char* kVerb = "set";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
  BodyProperties properties = {};
};

// A new one, where none is named: what `tool` holds at `pose`. It can't be locked.
struct BodyAdd {
  static constexpr const char* kVerb = "add";
  static constexpr BodyRule kRule{0};
  Tool tool = BallTool{};
  Pose pose = {};
  uint8_t material = 0;
  BodyProperties properties = {};
};

// What the first holds of the way of `tool` becomes no-go: a body of its own, or of the second.
struct BodyProtect {
  static constexpr const char* kVerb = "protect";
  static constexpr BodyRule kRule{1, BodyRule::Changes::none};
  Tool tool = BallTool{};
  std::vector<Vec3> way_mm = {};                         // of its tip, upright, in the world
  SplineOperation operation = SplineOperation::deposit;  // cut: it may be cut again
  bool follows = true;             // a mask that is made moves, turns and mirrors with the first
  BodyProperties properties = {};  // of a mask that is made: its name
};

// What a shape makes is added, or cut from it; or all else goes.
struct BodySpline {
  static constexpr const char* kVerb = "spline";
  static constexpr BodyRule kRule{};
  SplineShape shape = {};  // in the world
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
};

// All verbs: the one list of them.
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

// The names of all verbs, in the order of BodyVerb; documents and messages call them so.
inline constexpr auto kBodyVerbs = internal::verbs_of(std::type_identity<BodyVerb>());

struct BodyAction {
  std::vector<BodyId> bodies;
  BodyVerb verb;
};

inline std::string_view verb_of(const BodyAction& action) {
  return kBodyVerbs[action.verb.index()];
}
// A verb by its name, with nothing said of it yet; none where there is no such verb.
std::optional<BodyVerb> default_verb(std::string_view name);

}  // namespace kibori
