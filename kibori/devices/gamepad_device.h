// SPDX-License-Identifier: MIT
// A game controller, through SDL2 (opened while running). It has no force, so it moves a simulated
// hand, which the force holds back as it would a real one, and rumbles: the slow motor with the
// force, the quick one with its roughness.
//
//   left stick    x and y: speed, up to 80 mm/s        A, B, X, Y    buttons 0 ... 3
//   right stick   z                                    left trigger  slower, for fine work
#pragma once

#include <memory>

#include <kibori/haptics/device.h>

namespace kibori {

class GamepadDevice final : public Device {
 public:
  // The first game controller. Errors: no SDL2, or no controller.
  static Result<std::unique_ptr<GamepadDevice>> open();
  ~GamepadDevice() override;

  const DeviceCapabilities& capabilities() const override;
  // Stale when the controller has not been asked for 0.1 s.
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct Link;
  explicit GamepadDevice(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace kibori
