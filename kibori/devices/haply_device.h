// SPDX-License-Identifier: MIT
// A Haply Inverse3, with a VerseGrip if there is one, through the Haply service (JSON over
// WebSocket). The service answers each frame with one frame. A separate thread waits for these
// answers. It exchanges only the newest values with the servo loop.
#pragma once

#include <memory>
#include <string>

#include <kibori/haptics/device.h>

namespace kibori {

class HaplyDevice final : public Device {
 public:
  // Connects to the service. Errors: no answer within two seconds; the program at this address is
  // not the Haply service; no Inverse3 is connected.
  static Result<std::unique_ptr<HaplyDevice>> open(const std::string& host = "localhost",
                                                   const std::string& port = "10001");
  ~HaplyDevice() override;

  const DeviceCapabilities& capabilities() const override;
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct Link;
  explicit HaplyDevice(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace kibori
