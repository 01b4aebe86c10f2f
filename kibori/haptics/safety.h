// SPDX-License-Identifier: MIT
// The last stage before any device: whatever is computed before it, no more than this comes out.
//
//        arm()          wanted force small         1 s
//   off ──────▶ waiting ──────────────────▶ ramp up ─────▶ full
//    ▲             command older than 2 ms: down to nothing within 5 ms, up again when it is fresh
//    └── latched: older than 20 ms, too fast, device error, unplugged, not finite: 0 at once
//
// Off until armed, and again after every trip, with the reason kept.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/base/result.h>
#include <kibori/haptics/device.h>

namespace kibori {

inline constexpr double kRampUpS = 1.0;    // from nothing to all
inline constexpr double kStaleS = 0.002;   // the force of a command older than this fades
inline constexpr double kFadeS = 0.005;    // a stale command's force has faded within this
inline constexpr double kDeadS = 0.020;    // a command older than this switches the device off
inline constexpr double kArmShare = 0.05;  // of the device's limits: what counts as small

enum class Trip : uint8_t {
  none,
  command_stale,
  over_speed,
  device_failed,
  device_unplugged,
  not_finite
};
// One sentence for a user.
std::string trip_text(Trip trip);

struct SafetyInput {
  Wrench wanted;
  double command_age_s = 0;  // how old what was computed is
  DeviceStatus device = DeviceStatus::ok;
  Vec3 velocity_mm_s = Vec3::Zero();
};

class SafetyStage {
 public:
  enum class State : uint8_t { off, waiting, on };

  SafetyStage(const DeviceCapabilities& limits, double tick_s);

  // Asks to begin; forgets the last trip.
  void arm();
  // Nothing at once, without a reason.
  void disarm();
  // One tick. What comes out is within the device's force, moment and rate limits; going to nothing
  // is never held back. Neither allocates nor fails.
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

// What is rendered, for the stability condition.
struct Rendering {
  double stiffness_n_mm = 0;   // k of the series tool
  double viscosity_ns_mm = 0;  // B: all viscosity that is rendered
  double tick_s = 0.001;       // T
};
// Ok if k T/2 + |B| is within the device's own damping (Colgate and Schenkel 1997); else one
// sentence saying what to change, and to what.
Status check_stability(const Rendering& rendering, const DeviceCapabilities& device);

}  // namespace kibori
