// SPDX-License-Identifier: MIT
// Force Dimension's devices (omega, delta, sigma, lambda) and the Novint Falcon, through the
// vendor's DHD library. open() loads it from $FORCEDIM_SDK or from the system's search path.
#pragma once

#include <chrono>
#include <memory>

#include <kibori/devices/shared_library.h>
#include <kibori/haptics/device.h>

namespace kibori {

class ForceDimensionDevice final : public Device {
 public:
  // Opens the first device. Errors: no library, a library without a required function, no device,
  // or an error from DHD.
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
