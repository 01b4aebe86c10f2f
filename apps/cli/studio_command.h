// SPDX-License-Identifier: MIT
// studio: carving by hand in the browser.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

class StudioCommand {
 public:
  explicit StudioCommand(CLI::App& app);
  bool given() const { return studio_->parsed(); }
  // Its exit status.
  int run() const;

 private:
  CLI::App* studio_;
  std::vector<std::string> publish_;
  std::string file_, stock_, device_, second_;
  uint16_t port_ = 0;
  bool no_browser_ = false, read_only_ = false, follow_ = false;
};
