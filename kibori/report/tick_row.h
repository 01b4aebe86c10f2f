// SPDX-License-Identifier: MIT
// One tick of one hand, as --publish sends it during carving: 256 bytes, little-endian.
// about_rows() returns a description of the columns for readers.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include <kibori/live/servo_context.h>

namespace kibori {

// One row. Units are mm, N, N mm and s.
struct TickRow {
  uint64_t tick = 0;  // number of the tick; a gap means that the reader lost ticks
  double time_s = 0;  // since the servo thread started
  // x, y, z [mm], then a quaternion x, y, z, w, in world coordinates.
  std::array<double, 7> tool_pose{}, hand_pose{};
  // The computed force on the tool [N], and the moment about its tip [N mm].
  std::array<double, 3> force_n{}, moment_nmm{};
  // The force and the moment that the device received.
  std::array<double, 3> given_force_n{}, given_moment_nmm{};
  double removed_mm3 = 0;  // negative: added
  double fallen_mm3 = 0;   // volume that fell away after the last stroke
  int64_t points = 0;      // number of lattice nodes that changed
  uint8_t hand = 1;        // 2: the second hand
  uint8_t mode = 0;        // index of the tool's mode in `modes` of about_rows()
  uint8_t touching = 0, cutting = 0, inside = 0;
  uint8_t clipped = 0;  // a deposit or dab reached beyond the lattice
  uint8_t safety = 0;   // 0: off; 1: waits until the computed force is small; 2: on
  uint8_t trip = 0;     // reason why the safety stage is off: index in `trips`
};
static_assert(sizeof(TickRow) == 256 && std::endian::native == std::endian::little);

// Returns a pose as numbers for files: x, y, z [mm], then a quaternion x, y, z, w.
std::array<double, 7> numbers_of(const Pose& pose);

// Appends one row for each hand.
void append_rows(const LiveTick& tick, std::vector<TickRow>& rows);

// The metadata for readers of rows. about_rows() returns it as JSON with program, document, device,
// rate, materials, units, and the columns of a row. A column has a name, a type (u8, u64, i64,
// f64), an offset in bytes and a count. docs/recordings.md describes the JSON.
struct Published {
  std::string document, device;
  double rate_hz = 1000;
  Lattice lattice;
  std::vector<Material> materials;
};
std::string about_rows(const Published& published);

}  // namespace kibori
