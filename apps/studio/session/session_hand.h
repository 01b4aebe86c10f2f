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

// The state of a force device that holds the tool.
struct HapticDeviceState {
  std::string name;
  double force_n = 0;                       // maximum force of the device
  double stiffness_n_mm = 0, max_n_mm = 0;  // at the hand: rendered stiffness, maximum stiffness
  double scale = 1;                         // mm of the tool per mm of the hand
  // The share of the wood's force that the hand receives: force_n divided by the hand's strength.
  double share = 1;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;
  double given_n = 0;
};

class SessionHand {
 public:
  // The pointer, which belongs to the servo. Null if a device holds the tool.
  PointerDevice* pointer = nullptr;
  std::optional<HapticDeviceState> held;
  double roll_rad = 0;  // rotation of the tool about its own axis

  bool pressed() const { return pressed_; }
  // Returns the number of the pointer's newest stroke.
  uint32_t stroke() const { return stroke_; }
  // Returns true if the tool has reached every pose of the pointer's last stroke.
  bool finished() const { return pointer->finished() >= stroke_; }

  // Moves the pointer to `tip_mm` at `time_s`, with the tool along `axis` (any length but 0).
  // Between strokes, the tool hovers there. `pressure` is that of a pen, 0 to 1.
  void aim(const Vec3& tip_mm, const Vec3& axis, double time_s, double pressure = 1);
  // Returns the pose at the beginning of a stroke, changed by `guide`. Returns nothing if the pose
  // or the time is not finite.
  std::optional<Pose> begin_at(const Vec3& tip_mm, const Vec3& axis, double time_s,
                               const StrokeGuideSettings& guide);
  void press(const Pose& pose, double time_s, double pressure = 1);
  void lift();
  // Stores the device's state that a tick reports.
  void note(const HandTick& tick);
  // Call this before the servo is destroyed, because the pointer belongs to the servo.
  void close();

 private:
  // Returns the pose of a tool with this tip and axis. If `upright` is true, the tool turns from
  // the upright pose to the axis by the shortest rotation. Otherwise, it turns from its last aimed
  // pose, so that it does not spin.
  std::optional<Pose> pose_of(const Vec3& tip_mm, const Vec3& axis, bool upright);

  uint32_t stroke_ = 0;
  bool pressed_ = false;
  double pressure_ = 1;            // newest pressure of the stroke
  Mat3 aimed_ = Mat3::Identity();  // last aimed frame, without the roll
  std::optional<StrokeGuide> guided_;
};

}  // namespace kibori
