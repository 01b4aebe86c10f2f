// SPDX-License-Identifier: MIT
// State of the fake of OpenHaptics' library: its next results, and its received values.
#pragma once

#include <atomic>

struct FakeHd {
  std::atomic<unsigned> init_error{0}, error{0};
  std::atomic<double> x{0}, max_force{3.3};
  std::atomic<int> buttons{0};
  std::atomic<double> force_y{0}, force_z{0};  // the last written
  std::atomic<int> frames{0}, disabled{0}, unscheduled{0};
  std::atomic<bool> output{false};
};
