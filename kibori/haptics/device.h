// SPDX-License-Identifier: MIT
// A force-feedback device as the servo loop sees it: pose and buttons in, wrench out. Errors are
// values; on the servo path nothing allocates, locks or throws. One file a device, in
// kibori/devices.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>

namespace kibori {

// What a device can do and bear. Limits it does not report are those of its data sheet.
struct DeviceCapabilities {
  std::string name;  // as a user knows it
  int dof_in = 3;    // 3: position; 6: orientation too
  // 0: none; 3: force; 5: moment but about the tool's axis; 6: force and moment.
  int dof_out = 3;
  double force_n = 3;                // the largest force it may be asked for
  double torque_nmm = 0;             // the largest moment
  double force_rate_n_s = 1000;      // how fast the force may change
  double torque_rate_nmm_s = 20000;  // how fast the moment may change
  double speed_mm_s = 1000;          // moving faster means that something is wrong
  double damping_ns_mm = 0.001;      // what its own mechanics take out, with a hand on it
  double stiffness_n_mm = 0.3;       // the stiffness to begin with
  Box workspace_mm;                  // about its own centre; empty: unknown
};

// The age of a reading that there has not been.
inline constexpr double kUnknownAge = 1e9;

enum class DeviceStatus : uint8_t {
  ok,
  stale,      // nothing new since the last read: what was read is older than a tick
  unplugged,  // it was there and is gone
  failed,     // it reports an error: see Device::complaint
};

struct DeviceReading {
  Vec3 position_mm = Vec3::Zero();  // x right, y away, z up, about the device's centre
  Mat3 frame = Mat3::Identity();    // of the grip; identity where it has no wrist
  Vec3 velocity_mm_s = Vec3::Zero();
  uint32_t buttons = 0;  // bit 0: the first
  double age_s = 0;      // how long ago it was so
};

class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceCapabilities& capabilities() const = 0;
  virtual DeviceStatus read(DeviceReading& reading) = 0;
  // Whether more readings are due in this tick: of a device that plays a path back and has fallen
  // behind.
  virtual bool behind() const { return false; }
  // Whether the hand works with its tool: a pointer does while it follows a stroke.
  virtual bool pressed() const { return true; }
  // The wrench to give from now on: N and N mm about the grip, in the device's axes.
  virtual DeviceStatus write(const Wrench& wrench) = 0;
  // The stiffness that forces will come from, for devices that go on by themselves between writes.
  virtual void expect_stiffness(double n_mm) { static_cast<void>(n_mm); }
  // One sentence about the last status that was not ok. Not for the servo path.
  virtual std::string complaint() const { return {}; }
};

}  // namespace kibori
