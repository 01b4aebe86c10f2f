// SPDX-License-Identifier: MIT
// 3D Systems' Touch family through the vendor's OpenHaptics library (libHD), which runs a scheduler
// thread of its own: that and the servo loop exchange the newest values.
#pragma once

#include <memory>

#include <kibori/haptics/device.h>

namespace kibori {

class OpenHapticsDevice final : public Device {
 public:
  // The default device. Errors: no library, a library without what is needed, or what it says.
  static Result<std::unique_ptr<OpenHapticsDevice>> open();
  ~OpenHapticsDevice() override;

  const DeviceCapabilities& capabilities() const override;
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct Link;
  explicit OpenHapticsDevice(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace kibori
