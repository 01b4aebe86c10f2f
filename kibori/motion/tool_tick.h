// SPDX-License-Identifier: MIT
// What a tool does in one tick, and what comes of it: the same for a DirectTool and a SpringTool.
#pragma once

#include <cstdint>

#include <kibori/base/names.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>

namespace kibori {

// cut: takes material away. deposit: puts material down. touch: feels what a cut would take away,
// and takes nothing. off: moves through material, feels nothing. The others reshape
// (reshape_stroke.h), and the tool itself only moves:
//
//   smooth ... flatten   a brush's dabs along the tip's way, in the order of FieldVerb
//   crease, paint        dabs, too
//   grab ... node        the surface follows the hand, in the order of WarpVerb
//   press                the tool pushes the material aside, which keeps its volume
//   throw, turn          the material turns about the vertical axis through the lattice's middle:
//   as
//                        clay on a wheel, which keeps its volume; as wood on a lathe, which is cut
enum class Mode {
  cut,
  deposit,
  touch,
  off,
  smooth,
  rasp,
  fill,
  inflate,
  flatten,
  crease,
  paint,
  grab,
  nudge,
  twist,
  bend,
  pinch,
  scale,
  node,
  press,
  throw_clay,
  turn
};
constexpr Names<21> names_of(Mode) {
  return {"cut",     "deposit", "touch",  "off",   "smooth", "rasp",  "fill",
          "inflate", "flatten", "crease", "paint", "grab",   "nudge", "twist",
          "bend",    "pinch",   "scale",  "node",  "press",  "throw", "turn"};
}
constexpr bool reshapes(Mode mode) { return mode >= Mode::smooth; }
// Whether it does so dab by dab; whether it is a function of the stroke's beginning.
constexpr bool dabs(Mode mode) { return mode >= Mode::smooth && mode <= Mode::paint; }
constexpr bool warps(Mode mode) { return mode >= Mode::grab && mode <= Mode::node; }
constexpr bool on_wheel(Mode mode) { return mode >= Mode::throw_clay; }

// Whether a stroke of it may leave what was one piece in several.
constexpr bool may_sever(Mode mode) {
  return mode != Mode::deposit && mode != Mode::touch && mode != Mode::off && mode != Mode::paint;
}

// Whether the end of its stroke is a tick of its own, that edits nothing: there what is owed of a
// press comes back, and a wheel meets the tool for the last time.
constexpr bool ends_apart(Mode mode) { return mode == Mode::press || on_wheel(mode); }

struct ToolTick {
  // Of the tool: where its tip ended, and by how much it moved and turned.
  Tick motion;
  Pose pose;  // of the tool, at the end
  // N, N mm about the tip: DirectTool: on the tool. SpringTool: on the hand.
  Wrench wrench;
  Vec3 stretch_mm = Vec3::Zero();  // SpringTool: of the spring that makes the wrench (see pull_of)
  double removed_mm3 = 0;          // negative: deposited
  // Lattice nodes that were removed or added: K of force model `paper`.
  int64_t points = 0;
  bool edited = false;    // the way was cut or filled: replayed, it must be again
  bool touching = false;  // SpringTool: material holds the tool back
  bool cutting = false;   // SpringTool: material was cut
  // SpringTool: the tool stands in material and waits to be pulled out.
  bool inside = false;
  bool clipped = false;  // a deposit reached beyond the lattice
};

}  // namespace kibori
