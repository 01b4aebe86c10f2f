// SPDX-License-Identifier: MIT
// One hand on the servo thread: a device that holds a tool. Reads where the hand is, moves the tool
// there through the model, and gives the device what is felt, within what is safe.
//
//   device.read ─► workspace ─► HandTool ─► passivity ─► safety ─► device.write
//
// A ServoContext has one hand or two, on one model; what both do in a tick is done one after the
// other.
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
  uint8_t material = 0;        // of a deposit
  SeriesSpring spring;         // its tick_s is set from the rate
  double force_scale = 1;      // of what the device gives, to what is computed
  double passivity_ns_mm = 0;  // the passivity controller's cap; 0: it only watches
  Workspace workspace;
  // The tool works only while the device says that the hand presses it (Device::pressed).
  bool while_pressed = false;
};

// What one hand's tool came to in one tick, in the world.
struct HandTick {
  Pose tool;
  Pose hand;              // where the hand wants the tool
  Mode mode = Mode::off;  // what the tool is to do
  // What the device is asked for, and what it is given: before and after the safety stage. Of the
  // force on the tool it is the share `force_scale`.
  Wrench computed, given;
  double force_scale = 1;
  double removed_mm3 = 0;
  bool touching = false, cutting = false, inside = false;
  bool clipped = false;  // material reached beyond the lattice, and is not there
  // Lattice nodes that vanished or came in this tick: K of force model `paper`. 0 where the
  // material is only felt.
  int64_t points = 0;
  SafetyStage::State safety = SafetyStage::State::off;
  Trip trip = Trip::none;  // why it is off
};

class ServoHand {
 public:
  // `settings` have passed check(), and outlive the hand.
  ServoHand(TriDexel& model, std::unique_ptr<Device> device, ServoHandSettings& settings,
            double rate_hz);

  // Errors: a tool or spring that can't be, or a rendering beyond the device's damping.
  static Status check(const ServoHandSettings& settings, ForceModel model, double rate_hz,
                      const DeviceCapabilities& device);

  Device& device() { return *device_; }
  SafetyStage& safety() { return safety_; }
  PassivityObserver& passivity() { return passivity_; }
  const PassivityObserver& passivity() const { return passivity_; }
  ServoHandSettings& settings() { return settings_; }
  const ServoHandSettings& settings() const { return settings_; }
  SpringTool& series() { return tool_.spring_tool(); }
  // The tool's, in the body.
  const Pose& pose() const { return tool_.pose(); }
  ForceLaw law(ForceModel model) const;

  // The spring that is felt, as it is set; where the device could not bear it, nothing changes.
  bool set_spring(const SeriesSpring& spring, double force_scale);
  void set_symmetry(const Symmetry& symmetry);
  void set_no_go(const NoGo* no_go);
  void set_grain(const Grain* grain);
  // The next reading of the device puts the tool there at once; nothing is cut on the way.
  void place_again() { placed_ = false; }
  // The tool is there, in the body; it is not known whether it stands in material.
  void place(const Pose& pose);
  void strike(double nmm) { strike_nmm_ = nmm; }

  // Whether it works with its tool: it does not while its clutch is held, or it is lifted.
  bool works() const;

  // Reads the device: where the hand wants the tool now, in a body that stands as `body` does
  // (null: as the world). Where the hand was not seen before, or leapt farther than a hand can go,
  // gives where the tool is to be placed; `leaps` counts the latter.
  std::optional<Pose> read(const Pose* body, uint64_t& leaps);
  // As another stroke, from which it can be carved again alone.
  void begin_stroke();
  // Where the tool was before, and what it did on its way to where the hand is, in the body.
  struct Advance {
    HandTick tick;
    Pose before;
    MoveTick recorded;
    bool possible = true;  // else its way was none, and the tool was put where the hand is
  };
  Advance advance(ForceModel model, Mode mode, const std::vector<Material>& materials);
  // Gives the device what `tick` has computed, in the world; what was given and whether it is safe
  // are put there.
  void give(HandTick& tick, double elapsed_s);
  // What it gave last.
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
  bool placed_ = false;  // the tool is where a hand was seen
  Pose wanted_;          // by the hand, in the last tick
  double strike_nmm_ = 0;
};

}  // namespace kibori
