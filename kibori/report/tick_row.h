// SPDX-License-Identifier: MIT
// One tick of one hand, as it is published while it is made: 256 bytes, little-endian. What readers
// are told of the columns (about_rows) is of this struct itself.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include <kibori/live/servo_context.h>

namespace kibori {

struct TickRow {
  uint64_t tick = 0;  // of all; one that is missing was left out
  double time_s = 0;  // since the servo thread began
  // x, y, z [mm], then the quaternion x, y, z, w, in the world.
  std::array<double, 7> tool_pose{}, hand_pose{};
  // On the tool [N], and about its tip [N mm].
  std::array<double, 3> force_n{}, moment_nmm{};
  // That the device was given.
  std::array<double, 3> given_force_n{}, given_moment_nmm{};
  double removed_mm3 = 0;  // less than 0: added
  double fallen_mm3 = 0;   // that the stroke before severed
  int64_t points = 0;      // lattice nodes that changed
  uint8_t hand = 1;        // 2: the second
  uint8_t mode = 0;        // what the tool is to do: a place in `modes` of what readers are told
  uint8_t touching = 0, cutting = 0, inside = 0;
  uint8_t clipped = 0;  // material reached beyond the lattice
  uint8_t safety = 0;   // 0 off, 1 waits for the hand to be still, 2 pushes
  uint8_t trip = 0;     // why it is off: a place in `trips`
};
static_assert(sizeof(TickRow) == 256 && std::endian::native == std::endian::little);

// A pose as researchers' files have it: x, y, z [mm], and the quaternion x, y, z, w.
std::array<double, 7> numbers_of(const Pose& pose);

// The rows of one tick: one for each hand.
void append_rows(const LiveTick& tick, std::vector<TickRow>& rows);

// What rows are of, for their readers: JSON of program, document, device, rate, materials, units,
// and the columns of a row: name, type (u8, u64, i64, f64), offset in bytes and how many.
// docs/recordings.md says what stands there.
struct Published {
  std::string document, device;
  double rate_hz = 1000;
  Lattice lattice;
  std::vector<Material> materials;
};
std::string about_rows(const Published& published);

}  // namespace kibori
