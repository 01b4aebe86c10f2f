// SPDX-License-Identifier: MIT
// The interface of a force-feedback device to the servo loop. A device reads a pose and buttons,
// and writes a wrench (a force and a moment). Errors are values. read(), write() and the other
// functions of the servo thread do not allocate, lock or throw. kibori/devices has one file per
// device.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>

namespace kibori {

// Properties and limits of a device. If the device does not report a limit, the limit comes from
// its data sheet.
struct DeviceCapabilities {
  std::string name;  // name shown to the user
  int dof_in = 3;    // 3: position; 6: position and orientation
  // 0: no force; 3: force; 5: also the moment, except about the tool's axis; 6: force and moment.
  int dof_out = 3;
  double force_n = 3;                // maximum force
  double torque_nmm = 0;             // maximum moment
  double force_rate_n_s = 1000;      // maximum rate of change of the force
  double torque_rate_nmm_s = 20000;  // maximum rate of change of the moment
  double speed_mm_s = 1000;          // a higher speed trips the safety stage
  double damping_ns_mm = 0.001;      // damping of the device's mechanics with a hand on it
  double stiffness_n_mm = 0.3;       // default stiffness of a SpringTool at this device
  Box workspace_mm;                  // relative to the workspace's centre; empty: unknown
};

// Value of DeviceReading::age_s before the first reading.
inline constexpr double kUnknownAge = 1e9;

enum class DeviceStatus : uint8_t {
  ok,
  stale,      // there is no new reading; the data is old
  unplugged,  // the device was connected, and is not any more
  failed,     // the device reports an error; see Device::complaint
};

struct DeviceReading {
  Vec3 position_mm = Vec3::Zero();  // from the device's centre: x right, y away from the user, z up
  Mat3 frame = Mat3::Identity();    // orientation of the grip; identity if the device has no wrist
  Vec3 velocity_mm_s = Vec3::Zero();
  uint32_t buttons = 0;  // bit 0: the first button
  double age_s = 0;      // age of the reading
  double pressure = 1;   // pressure of a pen, 0 to 1; 1 for other devices
};

class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceCapabilities& capabilities() const = 0;
  // Writes the newest reading to `reading`.
  virtual DeviceStatus read(DeviceReading& reading) = 0;
  // Returns true if the tick should call read() again. A device that plays a path can fall behind.
  virtual bool behind() const { return false; }
  // Returns true if the device keeps its path until it is read. Then a tick may skip read() without
  // a loss of path.
  virtual bool can_wait() const { return false; }
  // Returns true if the tool may edit now. A pointer returns true only during a stroke.
  virtual bool pressed() const { return true; }
  // Sets the wrench that the device outputs from now on: N, and N mm about the grip, in the
  // device's axes.
  virtual DeviceStatus write(const Wrench& wrench) = 0;
  // Sets the stiffness by which the force changes between two writes. Devices that extrapolate use
  // it.
  virtual void expect_stiffness(double n_mm) { static_cast<void>(n_mm); }
  // Returns one sentence about the last status that was not `ok`. Not for the servo thread.
  virtual std::string complaint() const { return {}; }
};

}  // namespace kibori
