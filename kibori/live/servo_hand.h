// SPDX-License-Identifier: MIT
// One hand on the servo thread: a device that holds a tool. It reads the hand's position and moves
// the tool there through the model. Then it sends the device the force, within safe limits.
//
//   device.read ─► workspace ─► HandTool ─► passivity ─► safety ─► device.write
//
// A ServoContext has one or two hands on one model. In a tick, they act one after the other.
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
  uint8_t material = 0;        // for a deposit
  SeriesSpring spring;         // its tick_s is set from the rate
  double force_scale = 1;      // ratio of the device's force to the computed one
  double passivity_ns_mm = 0;  // the passivity controller's limit; 0: it only observes
  Workspace workspace;
  // The tool works only while the device reports that the hand presses it (Device::pressed).
  bool while_pressed = false;
};

// Result of one hand's tool in one tick, in the world.
struct HandTick {
  Pose tool;
  Pose hand;              // where the hand wants the tool
  Mode mode = Mode::off;  // of the tool in this tick (ServoContext::mode_now)
  // The force for the device before and after the safety stage. It is `force_scale` times the force
  // on the tool.
  Wrench computed, given;
  double force_scale = 1;
  double removed_mm3 = 0;
  bool touching = false, cutting = false, inside = false;
  bool clipped = false;  // material beyond the lattice was lost
  // Lattice nodes that the tick removed or added: K of force model `paper`. 0 if the tool changes
  // no material.
  int64_t points = 0;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;  // why the safety stage is off
};

class ServoHand {
 public:
  // `settings` must have passed check(), and must outlive the hand.
  ServoHand(TriDexel& model, std::unique_ptr<Device> device, ServoHandSettings& settings,
            double rate_hz);

  // Errors: an invalid tool or spring, or a rendering that exceeds the device's damping.
  static Status check(const ServoHandSettings& settings, ForceModel model, double rate_hz,
                      const DeviceCapabilities& device);

  Device& device() { return *device_; }
  SafetyStage& safety() { return safety_; }
  PassivityObserver& passivity() { return passivity_; }
  const PassivityObserver& passivity() const { return passivity_; }
  ServoHandSettings& settings() { return settings_; }
  const ServoHandSettings& settings() const { return settings_; }
  SpringTool& series() { return tool_.spring_tool(); }
  // The tool's pose, in the body's coordinates.
  const Pose& pose() const { return tool_.pose(); }
  ForceLaw law(ForceModel model) const;

  // Sets the spring and the force's scale. Returns false and changes nothing if the device cannot
  // render them.
  bool set_spring(const SeriesSpring& spring, double force_scale);
  void set_symmetry(const Symmetry& symmetry);
  void set_no_go(const NoGo* no_go);
  void set_grain(const Grain* grain);
  // At the next reading of the device, the tool jumps to that pose and cuts nothing in between.
  void place_again() { placed_ = false; }
  // Places the tool, in the body's coordinates. Does not check for material there.
  void place(const Pose& pose);
  void strike(double nmm) { strike_nmm_ = nmm; }

  // True if the hand works with its tool. False while its clutch is held, or while it is lifted.
  bool works() const;

  // Reads the pose that the hand wants from the device, and converts it to a body with pose `body`
  // (null: the world's). At the first reading, and if the hand has jumped, returns the pose at
  // which the tool must be placed. `leaps` counts jumps.
  std::optional<Pose> read(const Pose* body, uint64_t& leaps);
  // Resets the state as for a new stroke, so that the stroke can be replayed alone.
  void begin_stroke();
  // Result of a motion of the tool to the hand's pose, in the body's coordinates.
  struct Advance {
    HandTick tick;
    Pose before;  // pose of the tool before the motion
    MoveTick recorded;
    bool possible = true;  // false: the motion was invalid, and the tool was placed at the hand
  };
  Advance advance(ForceModel model, Mode mode, const std::vector<Material>& materials);
  // Sends the device the force computed in `tick`, in the world. Stores in `tick` what was sent,
  // and the state of the safety stage.
  void give(HandTick& tick, double elapsed_s);
  // Of the pen that holds the tool, 0 to 1: see DeviceReading.
  double pressure() const { return reading_.pressure; }
  // The last force that was sent.
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
  bool placed_ = false;  // the tool follows the readings; false: place it at the next one
  Pose wanted_;          // by the hand, in the last tick
  double strike_nmm_ = 0;
};

}  // namespace kibori
