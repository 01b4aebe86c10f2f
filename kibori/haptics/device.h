// SPDX-License-Identifier: MIT
// Interface of a force-feedback device to the servo loop: reads pose and buttons, writes a wrench.
// Errors are values. The functions that the servo thread calls do not allocate, lock or throw.
// kibori/devices has one file per device.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>

namespace kibori {

// Properties and limits of a device. Limits that it does not report come from its data sheet.
struct DeviceCapabilities {
  std::string name;  // name shown to the user
  int dof_in = 3;    // 3: position; 6: position and orientation
  // 0: none; 3: force; 5: moment without the component about the tool's axis; 6: force and moment.
  int dof_out = 3;
  double force_n = 3;                // maximum force
  double torque_nmm = 0;             // maximum moment
  double force_rate_n_s = 1000;      // maximum rate of change of the force
  double torque_rate_nmm_s = 20000;  // maximum rate of change of the moment
  double speed_mm_s = 1000;          // a higher speed counts as an error
  double damping_ns_mm = 0.001;      // damping of its mechanics with a hand on it
  double stiffness_n_mm = 0.3;       // default stiffness of a spring tool at this device
  Box workspace_mm;                  // about its own centre; empty: unknown
};

// Value of DeviceReading::age_s before the first reading.
inline constexpr double kUnknownAge = 1e9;

enum class DeviceStatus : uint8_t {
  ok,
  stale,      // no fresh reading: the data is older than a tick
  unplugged,  // the device was connected and no longer is
  failed,     // the device reports an error: see Device::complaint
};

struct DeviceReading {
  Vec3 position_mm = Vec3::Zero();  // x right, y away, z up, from the device's centre
  Mat3 frame = Mat3::Identity();    // of the grip; identity if the device has no wrist
  Vec3 velocity_mm_s = Vec3::Zero();
  uint32_t buttons = 0;  // bit 0: the first
  double age_s = 0;      // age of the reading
  double pressure = 1;   // of a pen, 0 to 1; 1 for any other hand
};

class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceCapabilities& capabilities() const = 0;
  virtual DeviceStatus read(DeviceReading& reading) = 0;
  // True if more readings are due in this tick: a device that plays a path can fall behind.
  virtual bool behind() const { return false; }
  // True if the device keeps its path until it is read. Then a tick may skip read(), and no part of
  // the path is lost.
  virtual bool can_wait() const { return false; }
  // True if the tool may edit now. With a pointer, this is so only during a stroke.
  virtual bool pressed() const { return true; }
  // Sets the wrench to output from now on: N, and N mm about the grip, in the device's axes.
  virtual DeviceStatus write(const Wrench& wrench) = 0;
  // Sets the stiffness with which the force changes between writes, for devices that extrapolate.
  virtual void expect_stiffness(double n_mm) { static_cast<void>(n_mm); }
  // One sentence about the last status that was not ok. Not for the servo thread.
  virtual std::string complaint() const { return {}; }
};

}  // namespace kibori
