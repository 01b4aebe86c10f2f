// SPDX-License-Identifier: MIT
// A hand behind DDS, as ROS 2 programs speak: its poses come in on /kibori/device/pose
// (PoseStamped), and what it is to feel goes out on /kibori/device/wrench (WrenchStamped), once a
// tick, or the newest where the network is slower. SI units: m, N, N m, about the device's own
// centre; x right, y away, z up. A thread of its own writes: the servo loop only exchanges the
// newest values with it.
#pragma once

#include <memory>
#include <string>

#include <kibori/haptics/device.h>

namespace kibori {

class DdsDevice final : public Device {
 public:
  // Errors: those of DdsLink::open.
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
