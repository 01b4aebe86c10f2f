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
  double force_n = 0;                       // max force
  double stiffness_n_mm = 0, max_n_mm = 0;  // at the hand: rendered, and max
  double scale = 1;                         // mm of the tool per mm of the hand
  // s: the share of the wood's force that the hand receives, force_n / strength.
  double share = 1;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;
  double given_n = 0;
};

class SessionHand {
 public:
  // Null if a device holds the tool. The servo owns it.
  PointerDevice* pointer = nullptr;
  std::optional<HapticDeviceState> held;
  double roll_rad = 0;  // the tool's rotation about its own axis

  bool pressed() const { return pressed_; }
  // The pointer's newest stroke.
  uint32_t stroke() const { return stroke_; }
  // True if the tool has reached every position of the pointer's last stroke.
  bool finished() const { return pointer->finished() >= stroke_; }

  // Moves the pointer to `tip_mm`, with the tool along `axis` (any nonzero length), at `time_s`.
  // Between strokes the tool hovers there. pressure: of a pen, 0 to 1.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s, double pressure = 1);
  // The pose at the beginning of a stroke, guided if `guide` guides. Nothing if the pose or the
  // time is not finite.
  std::optional<Pose> begin_at(const Vec3& tip_mm, const Vec3& axis, double time_s,
                               const StrokeGuideSettings& guide);
  void press(const Pose& pose, double time_s, double pressure = 1);
  void lift();
  // Stores the device's state that a tick reports.
  void note(const HandTick& tick);
  // Call this before the servo is destroyed, because it owns the pointer.
  void close();

 private:
  // The pose of a tool with this tip and axis. If `upright`, the shortest rotation turns the tool
  // from upright to the axis. Otherwise it turns the tool from its last aimed pose, so that the
  // tool does not spin.
  std::optional<Pose> pose_of(const Vec3& tip_mm, const Vec3& axis, bool upright);

  uint32_t stroke_ = 0;
  bool pressed_ = false;
  double pressure_ = 1;            // the newest of the stroke
  Mat3 aimed_ = Mat3::Identity();  // the last aimed frame, before the roll
  std::optional<StrokeGuide> guided_;
};

}  // namespace kibori
