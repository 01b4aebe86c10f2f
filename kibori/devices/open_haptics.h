// SPDX-License-Identifier: MIT
// 3D Systems' Touch family, through the vendor's OpenHaptics library (libHD). The library runs a
// scheduler thread, which exchanges the newest values with the servo loop.
#pragma once

#include <memory>

#include <kibori/haptics/device.h>

namespace kibori {

class OpenHapticsDevice final : public Device {
 public:
  // Opens the default device. Errors: no library, a library without a required function, or an
  // error from the library.
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
