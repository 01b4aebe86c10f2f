// SPDX-License-Identifier: MIT
// A haptic device behind DDS, for example a ROS 2 program. Its poses arrive on /kibori/device/pose
// (PoseStamped). Its forces are sent on /kibori/device/wrench (WrenchStamped) once per tick, or
// only the newest if the network is slower.
//
// SI units: m, N, N m, about the device's centre. x is right, y away from the user, z up. A
// separate thread writes. The servo loop only exchanges the newest values with it.
#pragma once

#include <memory>
#include <string>

#include <kibori/haptics/device.h>

namespace kibori {

class DdsDevice final : public Device {
 public:
  // Errors: see DdsLink::open.
  static Result<std::unique_ptr<DdsDevice>> open(uint32_t domain);
  ~DdsDevice() override;

  const DeviceCapabilities& capabilities() const override;
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct State;
  explicit DdsDevice(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
