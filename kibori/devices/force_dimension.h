// SPDX-License-Identifier: MIT
// Devices of Force Dimension (omega, delta, sigma, lambda) and the Novint Falcon, through the
// vendor's DHD library. open() loads the library from $FORCEDIM_SDK or from the system's search
// path.
#pragma once

#include <chrono>
#include <memory>

#include <kibori/devices/shared_library.h>
#include <kibori/haptics/device.h>

namespace kibori {

class ForceDimensionDevice final : public Device {
 public:
  // Opens the first device. Errors: the library is missing or lacks a function; no device is
  // plugged in; DHD reports an error.
  static Result<std::unique_ptr<ForceDimensionDevice>> open();
  ~ForceDimensionDevice() override;

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct Functions;
  ForceDimensionDevice();
  DeviceStatus judge(int result);
  using Clock = std::chrono::steady_clock;

  SharedLibrary library_;
  std::unique_ptr<Functions> dhd_;
  signed char id_ = -1;
  DeviceCapabilities capabilities_;
  bool failed_ = false, unplugged_ = false;
  Clock::time_point fresh_ = Clock::now();
};

}  // namespace kibori
