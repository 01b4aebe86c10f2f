// SPDX-License-Identifier: MIT
// The commands `devices` and `servo`, for carving with a force device.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

class ServoCommands {
 public:
  explicit ServoCommands(CLI::App& app);
  // Returns true if the user gave one of these commands.
  bool given() const { return *devices_ || *servo_; }
  // Runs the command. Returns its exit status.
  int run() const { return *devices_ ? run_devices() : run_servo(); }

 private:
  int run_devices() const;
  int run_servo() const;

  CLI::App *devices_, *servo_;
  std::vector<std::string> publish_;
  std::string scene_, device_ = "virtual", model_, record_, document_;
  double seconds_ = 10, rate_hz_ = 1000, stiffness_n_mm_ = 0;
  bool no_surface_ = false, json_ = false, keep_forces_ = false;
};
