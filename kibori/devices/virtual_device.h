// SPDX-License-Identifier: MIT
// A simulated device. A simulated hand holds the device and follows a target. A script moves the
// target. The forces that are written to the device act on the hand.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <utility>

#include <kibori/haptics/device.h>
#include <kibori/haptics/hand.h>

namespace kibori {

// Settings of a simulated hand and its device.
struct VirtualDeviceSettings {
  DeviceCapabilities capabilities;
  HandSettings hand;
  double tick_s = 0.001;
  double count_mm = 0.01;  // resolution of the device's encoders; 0: unlimited
  int delay_ticks = 0;     // delay of written forces [ticks], 0 ... 8
};

// Returns the settings of a hand with a wrist. Its device outputs force and moment, at `rate_hz`.
inline VirtualDeviceSettings wristed_hand(std::string name, double rate_hz) {
  VirtualDeviceSettings settings;
  settings.capabilities.name = std::move(name);
  settings.capabilities.dof_in = settings.capabilities.dof_out = 6;
  settings.capabilities.torque_nmm = 100;
  settings.tick_s = 1 / rate_hz;
  return settings;
}

class VirtualDevice final : public Device {
 public:
  // The pose that the hand wants, and the buttons that it presses. A script returns it for a time
  // [s] since the first read().
  struct Target {
    Vec3 position_mm = Vec3::Zero();
    Mat3 frame = Mat3::Identity();
    uint32_t buttons = 0;
  };
  using Script = std::function<Target(double time_s)>;

  VirtualDevice(const VirtualDeviceSettings& settings, Script script);

  const DeviceCapabilities& capabilities() const override { return settings_.capabilities; }
  // Each read() is one tick after the last read(), at any real time.
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

  // From the next read() on, the device behaves as with this status. For tests.
  void pretend(DeviceStatus status) { status_ = status; }
  const SimulatedHand& hand() const { return hand_; }

 private:
  static constexpr int kMaxDelay = 8;
  VirtualDeviceSettings settings_;
  Script script_;
  SimulatedHand hand_;
  Target target_;
  double time_s_ = 0;
  bool started_ = false;
  Vec3 last_read_ = Vec3::Zero();
  std::array<Vec3, kMaxDelay + 1> forces_;  // the newest force is first
  DeviceStatus status_ = DeviceStatus::ok;
};

}  // namespace kibori
