// SPDX-License-Identifier: MIT
// The modes of a tool and their classification. Each property of a mode is defined here once.
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
  smooth,   // this and the next modes: dabs of a brush along the path of the tip
  rasp,
  fill,
  inflate,
  flatten,
  crease,
  paint,
  grab,  // this and the next modes are warps: the surface follows the hand
  nudge,
  twist,
  bend,
  pinch,
  scale,
  node,
  press,  // the tool pushes material aside; the volume is kept
  // Material turns about the vertical axis through the lattice's centre. throw_clay: clay on a
  // wheel, which keeps its volume. turn: wood on a lathe.
  throw_clay,
  turn,
  // Later modes. They are last because a page's message holds the index of a mode.
  trim,
  build,
  snake_hook,      // a dab that pulls the surface along the path
  grab_connected,  // a warp: grab, but only of points connected to its centre through material
  mask             // a dab that masks the surface, so that brushes move it less
};
constexpr Names<26> names_of(Mode) {
  return {"cut",   "deposit", "touch",   "off",        "smooth",
          "rasp",  "fill",    "inflate", "flatten",    "crease",
          "paint", "grab",    "nudge",   "twist",      "bend",
          "pinch", "scale",   "node",    "press",      "throw",
          "turn",  "trim",    "build",   "snake_hook", "grab_connected",
          "mask"};
}

// How a mode works. `edit`: the tool edits the model. `none`: nothing is edited. In all other kinds
// reshape_stroke.h edits the model, and the tool only moves.
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
// A warp is a function of the model at the stroke's beginning.
constexpr bool warps(Mode mode) { return kind_of(mode) == ModeKind::warp; }
// The surface resists like a spring (MaxwellForce), because it follows the hand.
constexpr bool pulls(Mode mode) { return warps(mode) || mode == Mode::snake_hook; }
constexpr bool on_wheel(Mode mode) { return kind_of(mode) == ModeKind::wheel; }
constexpr bool reshapes(Mode mode) {
  return kind_of(mode) != ModeKind::edit && kind_of(mode) != ModeKind::none;
}

// True if a stroke can add material where there is none, so that it may need a larger lattice.
constexpr bool may_grow(Mode mode) {
  return mode == Mode::deposit || (reshapes(mode) && mode != Mode::paint && mode != Mode::rasp &&
                                   mode != Mode::trim && mode != Mode::turn);
}

// True if a stroke can cut one piece into several.
constexpr bool may_sever(Mode mode) {
  return mode != Mode::deposit && mode != Mode::build && mode != Mode::paint &&
         mode != Mode::mask && kind_of(mode) != ModeKind::none;
}

// True if a brush works towards a plane (FlattenTo).
constexpr bool to_plane(Mode mode) {
  return mode == Mode::flatten || mode == Mode::trim || mode == Mode::build;
}

// True if a negative strength does the opposite.
constexpr bool has_opposite(Mode mode) {
  return mode == Mode::inflate || mode == Mode::crease || mode == Mode::pinch || mode == Mode::mask;
}

// True if the stroke's end changes the model and is recorded as its own tick. There a press returns
// its pending material, and the tool shapes a body on the wheel for the last time.
constexpr bool ends_apart(Mode mode) { return mode == Mode::press || on_wheel(mode); }

// Returns Ok, or an error sentence if no stroke can use these modes together. Scenes, Python,
// documents and the studio all show this sentence. `second`: mode of the second hand, if there is
// one. `protects`: a protected body limits the stroke.
Status check_modes(Mode first, std::optional<Mode> second, bool protects);

}  // namespace kibori
