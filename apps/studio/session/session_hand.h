// SPDX-License-Identifier: MIT
// One hand of a live session: a pointer that aims, presses and lifts a tool, or a force device.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <kibori/devices/pointer_device.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/safety.h>
#include <kibori/live/servo_hand.h>
#include <kibori/motion/stroke_guide.h>

namespace kibori {

// A force device that holds the tool.
struct HapticDeviceState {
  std::string name;
  double force_n = 0;                       // the most it can give
  double stiffness_n_mm = 0, max_n_mm = 0;  // at the hand: what is rendered, and what it can bear
  double scale = 1;                         // so far the tool goes for a mm of the hand
  // s: of the wood's force, what is felt: force_n / strength.
  double share = 1;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;
  double given_n = 0;
};

class SessionHand {
 public:
  // Null where a device holds the tool. The servo owns it.
  PointerDevice* pointer = nullptr;
  std::optional<HapticDeviceState> held;
  double roll_rad = 0;  // by which the tool is turned about its own axis

  bool pressed() const { return pressed_; }
  // The pointer's newest stroke.
  uint32_t stroke() const { return stroke_; }
  // The pointer has been everywhere that its last stroke went to.
  bool finished() const { return pointer->finished() >= stroke_; }

  // The pointer is at `tip_mm`, with the tool along `axis` (any length but zero), at `time_s`.
  // Between strokes the tool hovers there.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s);
  // Where a stroke begins; it is guided if `guide` is. Nothing for a pose or a time that is not
  // finite.
  std::optional<Pose> begin_at(const Vec3& tip_mm, const Vec3& axis, double time_s,
                               const StrokeGuideSettings& guide);
  void press(const Pose& pose, double time_s);
  void lift();
  // Takes over what the device did in a tick.
  void note(const HandTick& tick);
  // The pointer is gone with its servo.
  void close();

 private:
  // How the tool stands there. `upright`: turned the shortest way from upright; else from where it
  // was aimed before, so that it does not spin.
  std::optional<Pose> pose_of(const Vec3& tip_mm, const Vec3& axis, bool upright);

  uint32_t stroke_ = 0;
  bool pressed_ = false;
  Mat3 aimed_ = Mat3::Identity();  // the frame aimed at last, before the roll
  std::optional<StrokeGuide> guided_;
};

}  // namespace kibori
