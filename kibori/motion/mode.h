// SPDX-License-Identifier: MIT
// The modes of a tool, and their properties. Each property is defined only here.
#pragma once

#include <optional>

#include <kibori/base/names.h>
#include <kibori/base/result.h>

namespace kibori {

enum class Mode {
  cut,      // removes material
  deposit,  // adds material
  touch,    // computes the force of a cut and removes nothing
  off,      // moves through material without a force
  smooth,   // from here to paint: dabs of a brush along the path of the tip
  rasp,
  fill,
  inflate,
  flatten,
  crease,
  paint,
  grab,  // from here to node: warps, in which the surface follows the hand
  nudge,
  twist,
  bend,
  pinch,
  scale,
  node,
  press,  // the tool pushes material aside; the volume stays constant
  // The material turns about the vertical axis through the lattice's centre. throw_clay: clay on a
  // potter's wheel, which keeps its volume. turn: wood on a lathe.
  throw_clay,
  turn,
  // Later modes come last, because the page's messages contain the index of a mode.
  trim,
  build,
  snake_hook,      // dabs that pull the surface along the path
  grab_connected,  // a warp like grab, but only for points that material connects with its centre
  mask             // dabs that mask the surface, so that brushes move it less
};
constexpr Names<26> names_of(Mode) {
  return {"cut",   "deposit", "touch",   "off",        "smooth",
          "rasp",  "fill",    "inflate", "flatten",    "crease",
          "paint", "grab",    "nudge",   "twist",      "bend",
          "pinch", "scale",   "node",    "press",      "throw",
          "turn",  "trim",    "build",   "snake_hook", "grab_connected",
          "mask"};
}

// What edits the model. `edit`: the tool. `none`: nothing. All other kinds: ReshapeStroke, while
// the tool only moves.
enum class ModeKind { edit, none, dab, warp, press, wheel };

constexpr ModeKind kind_of(Mode mode) {
  switch (mode) {
    case Mode::cut:
    case Mode::deposit:
      return ModeKind::edit;
    case Mode::touch:
    case Mode::off:
      return ModeKind::none;
    case Mode::smooth:
    case Mode::rasp:
    case Mode::fill:
    case Mode::inflate:
    case Mode::flatten:
    case Mode::crease:
    case Mode::paint:
    case Mode::trim:
    case Mode::build:
    case Mode::snake_hook:
    case Mode::mask:
      return ModeKind::dab;
    case Mode::grab:
    case Mode::nudge:
    case Mode::twist:
    case Mode::bend:
    case Mode::pinch:
    case Mode::scale:
    case Mode::node:
    case Mode::grab_connected:
      return ModeKind::warp;
    case Mode::press:
      return ModeKind::press;
    case Mode::throw_clay:
    case Mode::turn:
      return ModeKind::wheel;
  }
  return ModeKind::none;
}

constexpr bool dabs(Mode mode) { return kind_of(mode) == ModeKind::dab; }
// True if the result is a function of the model at the stroke's beginning.
constexpr bool warps(Mode mode) { return kind_of(mode) == ModeKind::warp; }
// True if the surface resists like a spring (MaxwellForce), because it follows the hand.
constexpr bool pulls(Mode mode) { return warps(mode) || mode == Mode::snake_hook; }
constexpr bool on_wheel(Mode mode) { return kind_of(mode) == ModeKind::wheel; }
constexpr bool reshapes(Mode mode) {
  return kind_of(mode) != ModeKind::edit && kind_of(mode) != ModeKind::none;
}

// True if a stroke can add material in empty space. Then it may need a larger lattice.
constexpr bool may_grow(Mode mode) {
  return mode == Mode::deposit || (reshapes(mode) && mode != Mode::paint && mode != Mode::rasp &&
                                   mode != Mode::trim && mode != Mode::turn);
}

// True if a stroke can separate one piece into several.
constexpr bool may_sever(Mode mode) {
  return mode != Mode::deposit && mode != Mode::build && mode != Mode::paint &&
         mode != Mode::mask && kind_of(mode) != ModeKind::none;
}

// True if the brush moves the surface towards a plane (FlattenTo).
constexpr bool to_plane(Mode mode) {
  return mode == Mode::flatten || mode == Mode::trim || mode == Mode::build;
}

// True if a negative strength has the opposite effect.
constexpr bool has_opposite(Mode mode) {
  return mode == Mode::inflate || mode == Mode::crease || mode == Mode::pinch || mode == Mode::mask;
}

// True if the end of a stroke changes the model and is recorded as a separate tick (EndTick). At
// the end, a press returns its pending material, and a tool on the wheel shapes the body once more.
constexpr bool ends_apart(Mode mode) { return mode == Mode::press || on_wheel(mode); }

// Returns Ok if a stroke can use these modes together. Otherwise, returns an error sentence, which
// scenes, Python, documents and the studio show to the user. `second` is the mode of the second
// hand, if there is one. `protects` is true if a protected body limits the stroke.
Status check_modes(Mode first, std::optional<Mode> second, bool protects);

}  // namespace kibori
