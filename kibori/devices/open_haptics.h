// SPDX-License-Identifier: MIT
// The Touch devices of 3D Systems, through the vendor's OpenHaptics library (libHD). The library
// runs a scheduler thread. This thread exchanges only the newest values with the servo loop.
#pragma once

#include <memory>

#include <kibori/haptics/device.h>

namespace kibori {

class OpenHapticsDevice final : public Device {
 public:
  // Opens the default device. Errors: the library is missing or lacks a function; the library
  // reports an error.
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
