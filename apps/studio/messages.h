// SPDX-License-Identifier: MIT
// Made by tools/make_protocol.py from protocol/messages.json: change that.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "apps/studio/wire.h"

namespace kibori::studio {

inline constexpr uint16_t kProtocolVersion = 1;

// The first message of a page.
struct Hello {
  static constexpr uint8_t kKind = 1;
  uint16_t version = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version);
  }
};
// Where the tool's tip is wanted [mm], and its axis, from the tip up.
struct Aim {
  static constexpr uint8_t kKind = 2;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis);
  }
};
// From now on the tool works: first it is put to `tip`, clear of material. mode: 0 cut, 1 fill.
struct Press {
  static constexpr uint8_t kKind = 3;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  uint8_t mode = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, mode);
  }
};
// The tool works no longer.
struct Lift {
  static constexpr uint8_t kKind = 4;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The stroke that is being made is as if it had not been.
struct Cancel {
  static constexpr uint8_t kKind = 5;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// One step back.
struct Undo {
  static constexpr uint8_t kKind = 6;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// One step forth.
struct Redo {
  static constexpr uint8_t kKind = 7;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// shape: 0 ball, 1 finger, 2 flat end mill, 3 capsule. size: radius [mm]; for the finger its Ks. length [mm].
struct ChooseTool {
  static constexpr uint8_t kKind = 8;
  uint8_t shape = 0;
  double size = 0;
  double length = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(shape, size, length);
  }
};
// Stiffness between hand and tool [N/mm].
struct ChooseSpring {
  static constexpr uint8_t kKind = 9;
  double stiffness = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(stiffness);
  }
};
// The page has drawn this frame of chunks, and can take the next.
struct Got {
  static constexpr uint8_t kKind = 10;
  uint32_t frame = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(frame);
  }
};
// This page wants to hold the tool; the others then watch.
struct TakeTool {
  static constexpr uint8_t kKind = 11;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The answer to Hello: the lattice (lower corner [mm], nodes, pitch [mm]), the servo's rate [Hz], the
// document.
struct Welcome {
  static constexpr uint8_t kKind = 64;
  uint16_t version = 0;
  Vec3 origin = Vec3::Zero();
  Vec3 nodes = Vec3::Zero();
  double pitch = 0;
  double rate = 0;
  std::string document;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, origin, nodes, pitch, rate, document);
  }
};
// Surface that changed; the page answers Got. Each chunk: place x y z (u16), numbers of vertices and
// triangles (u32), vertices, corners (u16 each). A vertex: x y z (u16, 1/2048 pitch from 16 place - 1),
// normal (3 x i8, 1/127), material (u8).
struct Chunks {
  static constexpr uint8_t kKind = 65;
  uint32_t frame = 0;
  uint8_t more = 0;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(frame, more, data);
  }
};
// Every servo tick since the last: tip [mm], force on the hand [N], moment about the tip [N mm], nine f32 a
// tick. start: number of the first.
struct Ticks {
  static constexpr uint8_t kKind = 66;
  double start = 0;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(start, data);
  }
};
// Volume [mm^3], what was removed since the studio began [mm^3], where the document stands; whether this page
// holds the tool.
struct State {
  static constexpr uint8_t kKind = 67;
  double volume = 0;
  double removed = 0;
  uint32_t step = 0;
  uint32_t steps = 0;
  uint8_t undo = 0;
  uint8_t redo = 0;
  uint8_t holds = 0;
  std::string hash;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(volume, removed, step, steps, undo, redo, holds, hash);
  }
};
// A sentence for the person.
struct Notice {
  static constexpr uint8_t kKind = 68;
  std::string text;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(text);
  }
};

// What a page may say.
using FromPage = std::variant<Hello, Aim, Press, Lift, Cancel, Undo, Redo, ChooseTool, ChooseSpring, Got, TakeTool>;

}  // namespace kibori::studio
