// SPDX-License-Identifier: MIT
// What a tool does on its path, and how the modes are classified: each in one place.
#pragma once

#include <optional>

#include <kibori/base/names.h>
#include <kibori/base/result.h>

namespace kibori {

enum class Mode {
  cut,      // removes material
  deposit,  // adds material
  touch,    // computes the force of a cut, and removes nothing
  off,      // moves through material, without a force
  smooth,   // these are a brush's dabs along the tip's path ...
  rasp,
  fill,
  inflate,
  flatten,
  crease,
  paint,
  grab,  // ... in these the surface follows the hand ...
  nudge,
  twist,
  bend,
  pinch,
  scale,
  node,
  press,       // ... here the tool pushes material aside, and the volume is kept ...
  throw_clay,  // ... and these turn the material about the vertical axis through the lattice's
  turn         // centre: as clay on a wheel, which keeps its volume, or as wood on a lathe
};
constexpr Names<21> names_of(Mode) {
  return {"cut",     "deposit", "touch",  "off",   "smooth", "rasp",  "fill",
          "inflate", "flatten", "crease", "paint", "grab",   "nudge", "twist",
          "bend",    "pinch",   "scale",  "node",  "press",  "throw", "turn"};
}

// How a mode works. `edit`: the tool itself edits the model. `none`: nothing is edited. The others
// reshape (reshape_stroke.h), and the tool itself only moves.
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
      return ModeKind::dab;
    case Mode::grab:
    case Mode::nudge:
    case Mode::twist:
    case Mode::bend:
    case Mode::pinch:
    case Mode::scale:
    case Mode::node:
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
constexpr bool on_wheel(Mode mode) { return kind_of(mode) == ModeKind::wheel; }
constexpr bool reshapes(Mode mode) {
  return kind_of(mode) != ModeKind::edit && kind_of(mode) != ModeKind::none;
}

// A stroke may cut one piece into several.
constexpr bool may_sever(Mode mode) {
  return mode != Mode::deposit && mode != Mode::paint && kind_of(mode) != ModeKind::none;
}

// The stroke's end changes the model, and is recorded as a tick of its own: pending material of a
// press comes back, and a wheel meets the tool for the last time.
constexpr bool ends_apart(Mode mode) { return mode == Mode::press || on_wheel(mode); }

// Ok, or the sentence that all of Kibori gives: no stroke works so. `second`: the second hand's
// mode, if there is one. `protects`: a protected (no-go) body limits the stroke.
Status check_modes(Mode first, std::optional<Mode> second, bool protects);

}  // namespace kibori
