// SPDX-License-Identifier: MIT
// A force-feedback device behind DDS, for example a ROS 2 program. Poses arrive on
// /kibori/device/pose (PoseStamped). Forces are sent on /kibori/device/wrench (WrenchStamped) in
// every tick. If the network is slower, only the newest force is sent.
//
// DDS messages use SI units (m, N, N m) about the device's centre. x is right, y away from the
// user, z up. A separate thread sends the forces. The servo loop exchanges only the newest values
// with it.
#pragma once

#include <memory>
#include <string>

#include <kibori/haptics/device.h>

namespace kibori {

class DdsDevice final : public Device {
 public:
  // Opens the device in this DDS domain. Errors: those of DdsLink::open.
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
