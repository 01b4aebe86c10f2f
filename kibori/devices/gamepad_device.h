// SPDX-License-Identifier: MIT
// A game controller, through SDL2 (loaded at run time). It has no force feedback. Therefore, it
// moves a simulated hand, and the force acts on this hand. The controller also rumbles: the slow
// motor with the force, and the fast motor with the fast changes of the force.
//
//   left stick    x and y: speed, up to 80 mm/s        A, B, X, Y    buttons 0 ... 3
//   right stick   z                                    left trigger  slower, for fine work
#pragma once

#include <memory>

#include <kibori/haptics/device.h>

namespace kibori {

class GamepadDevice final : public Device {
 public:
  // Opens the first game controller. Errors: SDL2 is missing, too old, or fails; no controller is
  // plugged in.
  static Result<std::unique_ptr<GamepadDevice>> open();
  ~GamepadDevice() override;

  const DeviceCapabilities& capabilities() const override;
  // Returns `stale` if the controller was not polled during the last 0.1 s.
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override;
  std::string complaint() const override;

 private:
  struct Link;
  explicit GamepadDevice(std::unique_ptr<Link> link);
  std::unique_ptr<Link> link_;
};

}  // namespace kibori
