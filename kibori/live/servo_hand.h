// SPDX-License-Identifier: MIT
// One hand on the servo thread: a device that holds a tool. A ServoHand reads the pose of the hand,
// and moves the tool through the model to this pose. Then it sends the force to the device, within
// safe limits.
//
//   device.read ─► workspace ─► HandTool ─► passivity ─► safety ─► device.write
//
// A ServoContext has one or two hands on one model. In a tick, the first hand acts before the
// second.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/haptics/device.h>
#include <kibori/haptics/passivity.h>
#include <kibori/haptics/safety.h>
#include <kibori/haptics/workspace.h>
#include <kibori/motion/hand_tool.h>

namespace kibori {

struct ServoHandSettings {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;
  uint8_t material = 0;        // material of a deposit
  SeriesSpring spring;         // the constructor sets its tick_s
  double force_scale = 1;      // force at the device / computed force
  double passivity_ns_mm = 0;  // maximum damping of the PassivityObserver; 0: it only counts
  Workspace workspace;
  // If true, the tool works only while Device::pressed() returns true.
  bool while_pressed = false;
};

// The result of one hand's tool in one tick, in world coordinates.
struct HandTick {
  Pose tool;
  Pose hand;              // the pose at which the hand wants the tool
  Mode mode = Mode::off;  // mode of the tool in this tick (ServoContext::mode_now)
  // The force for the device, before and after the safety stage. It is the computed force times
  // `force_scale`.
  Wrench computed, given;
  double force_scale = 1;
  double removed_mm3 = 0;
  bool touching = false, cutting = false, inside = false;
  bool clipped = false;  // true if material beyond the lattice was lost
  // Number of lattice nodes that the tick removed or added: K of the force model `paper`. 0 if the
  // tool changed no material.
  int64_t points = 0;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;  // the reason why the safety stage is off
};

class ServoHand {
 public:
  // `settings` must have passed check(), and must outlive this object.
  ServoHand(TriDexel& model, std::unique_ptr<Device> device, ServoHandSettings& settings,
            double rate_hz);

  // Returns Ok if the settings are valid. Errors: the force's scale, the tool or the spring is
  // invalid; the force needs more damping than the device has.
  static Status check(const ServoHandSettings& settings, ForceModel model, double rate_hz,
                      const DeviceCapabilities& device);

  Device& device() { return *device_; }
  SafetyStage& safety() { return safety_; }
  PassivityObserver& passivity() { return passivity_; }
  const PassivityObserver& passivity() const { return passivity_; }
  ServoHandSettings& settings() { return settings_; }
  const ServoHandSettings& settings() const { return settings_; }
  SpringTool& series() { return tool_.spring_tool(); }
  // Returns the pose of the tool, in the coordinates of the body.
  const Pose& pose() const { return tool_.pose(); }
  ForceLaw law(ForceModel model) const;

  // Sets the spring, and the scale of the force. Returns false and changes nothing if the device
  // cannot render them.
  bool set_spring(const SeriesSpring& spring, double force_scale);
  void set_symmetry(const Symmetry& symmetry);
  void set_no_go(const NoGo* no_go);
  void set_grain(const Grain* grain);
  // At the next reading of the device, the tool jumps to the hand's pose. It cuts nothing on the
  // path.
  void place_again() { placed_ = false; }
  // Places the tool, without a check for material. `pose` is in the coordinates of the body.
  void place(const Pose& pose);
  void strike(double nmm) { strike_nmm_ = nmm; }

  // Returns true if the hand works with its tool. Returns false while the clutch is held, and while
  // the device is not pressed (while_pressed).
  bool works() const;

  // Reads the device. Computes the pose that the hand wants, in the coordinates of a body with the
  // pose `body` (null: the world). Normally returns nullopt. At the first reading, and after a jump
  // of the hand, returns the pose at which the caller must place the tool. `leaps` counts the
  // jumps.
  std::optional<Pose> read(const Pose* body, uint64_t& leaps);
  // Clears the state of earlier strokes, so that the next stroke can be replayed alone.
  void begin_stroke();
  // The result of a motion of the tool to the hand's pose, in the coordinates of the body.
  struct Advance {
    HandTick tick;
    Pose before;  // pose of the tool before the motion
    MoveTick recorded;
    bool possible = true;  // false: the motion was too long, and the tool was placed at the hand
  };
  Advance advance(ForceModel model, Mode mode, const std::vector<Material>& materials);
  // Sends the force of `tick` to the device. `tick` must be in world coordinates. Writes to `tick`
  // what was sent, and the state of the safety stage.
  void give(HandTick& tick, double elapsed_s);
  // Returns the pressure of the pen that holds the tool, 0 to 1: see DeviceReading.
  double pressure() const { return reading_.pressure; }
  // Returns the last force that was sent to the device.
  const Wrench& given() const { return given_; }

 private:
  TriDexel& model_;
  std::unique_ptr<Device> device_;
  ServoHandSettings& settings_;
  const double tick_s_;
  HandTool tool_;
  SafetyStage safety_;
  PassivityObserver passivity_;
  DeviceReading reading_;
  Wrench given_;
  DeviceStatus status_ = DeviceStatus::ok;
  bool placed_ = false;  // false: the next reading places the tool, without a path
  Pose wanted_;          // pose that the hand wanted in the last tick
  double strike_nmm_ = 0;
};

}  // namespace kibori
