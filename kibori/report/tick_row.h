// SPDX-License-Identifier: MIT
// One tick of one hand, as --publish sends it during carving: 256 bytes, little-endian. about_rows
// describes the columns of this struct to readers.
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
  uint64_t tick = 0;  // number of the tick; a gap means that ticks were lost
  double time_s = 0;  // since the servo thread started
  // x, y, z [mm], then the quaternion x, y, z, w, in the world.
  std::array<double, 7> tool_pose{}, hand_pose{};
  // Computed force on the tool [N], and moment about its tip [N mm].
  std::array<double, 3> force_n{}, moment_nmm{};
  // Sent to the device.
  std::array<double, 3> given_force_n{}, given_moment_nmm{};
  double removed_mm3 = 0;  // negative: added
  double fallen_mm3 = 0;   // volume that fell away at the end of the last stroke
  int64_t points = 0;      // lattice nodes that changed
  uint8_t hand = 1;        // 2: the second hand
  uint8_t mode = 0;        // of the tool in the tick: an index into `modes` of about_rows
  uint8_t touching = 0, cutting = 0, inside = 0;
  uint8_t clipped = 0;  // material reached beyond the lattice
  uint8_t safety = 0;   // 0 off, 1 waits until the computed force is small, 2 on
  uint8_t trip = 0;     // why the safety stage is off: an index into `trips`
};
static_assert(sizeof(TickRow) == 256 && std::endian::native == std::endian::little);

// A pose for files: x, y, z [mm], and the quaternion x, y, z, w.
std::array<double, 7> numbers_of(const Pose& pose);

// Appends one row per hand for one tick.
void append_rows(const LiveTick& tick, std::vector<TickRow>& rows);

// Metadata for readers of rows: JSON with program, document, device, rate, materials, units, and
// the columns of a row. A column has a name, type (u8, u64, i64, f64), offset in bytes and count.
// docs/recordings.md describes it.
struct Published {
  std::string document, device;
  double rate_hz = 1000;
  Lattice lattice;
  std::vector<Material> materials;
};
std::string about_rows(const Published& published);

}  // namespace kibori
