// SPDX-License-Identifier: MIT
// The last stage before a device. It limits every output, for any input.
//
//        arm()          wanted force small         1 s
//   off ──────▶ waiting ──────────────────▶ ramp up ─────▶ full
//    ▲             command older than 2 ms: fades to 0 within 5 ms, ramps up again when it is fresh
//    └── trip: command older than 20 ms, too fast, device error, unplugged, not finite: 0 at once
//
// A command is the newest computed wrench. The stage is off until it is armed. A trip switches it
// off again, and the stage keeps the reason.
//
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/haptics/device.h>

namespace kibori {

inline constexpr double kRampUpS = 1.0;    // from 0 to full force
inline constexpr double kStaleS = 0.002;   // the force of a command older than this fades
inline constexpr double kFadeS = 0.005;    // time in which this force fades from full to 0
inline constexpr double kDeadS = 0.020;    // a command older than this trips the stage
inline constexpr double kArmShare = 0.05;  // limit of a "small" force, as a share of the maximum

enum class Trip : uint8_t {
  none,
  command_stale,
  over_speed,
  device_failed,
  device_unplugged,
  not_finite
};
// Returns one sentence for the user.
std::string trip_text(Trip trip);

struct SafetyInput {
  Wrench wanted;
  double command_age_s = 0;  // age of the computed command
  DeviceStatus device = DeviceStatus::ok;
  Vec3 velocity_mm_s = Vec3::Zero();
};

class SafetyStage {
 public:
  enum class State : uint8_t { off, waiting, on };

  SafetyStage(const DeviceCapabilities& limits, double tick_s);

  // Permits forces, and clears the last trip.
  void arm();
  // Sets the output to 0 at once, without a trip.
  void disarm();
  // Runs one tick and returns the output. It is within the device's limits of force, moment and
  // their rates. The rate limit never delays a decrease. Does not allocate or fail.
  Wrench pass(const SafetyInput& input);

  State state() const { return state_; }
  Trip trip() const { return trip_; }
  double gain() const { return gain_; }  // 0 ... 1

 private:
  Wrench latch(Trip trip);

  const double force_n_, torque_nmm_, force_step_n_, torque_step_nmm_, speed_mm_s_, tick_s_;
  State state_ = State::off;
  Trip trip_ = Trip::none;
  double gain_ = 0;
  Wrench last_;
};

// Properties of the force that a device outputs, for check_stability.
struct Rendering {
  double stiffness_n_mm = 0;   // k of the spring of model `series`
  double viscosity_ns_mm = 0;  // B: sum of all rendered damping
  double tick_s = 0.001;       // T: period of the servo loop
};
// Returns Ok if k T/2 + |B| is at most the device's own damping (Colgate and Schenkel 1997).
// Otherwise, returns an error sentence. It names the setting to change, and a suitable value.
Status check_stability(const Rendering& rendering, const DeviceCapabilities& device);

}  // namespace kibori
