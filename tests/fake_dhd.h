// SPDX-License-Identifier: MIT
// State of the fake of Force Dimension's library: its next results, and its received values.
#pragma once

struct FakeDhd {
  int devices = 1, open_result = 0, enable_result = 0, read_result = 0, velocity_result = 0,
      frame_result = 0, write_result = 0, error = 0;
  bool wrist = true, active_wrist = true;
  double max_force = 12;
  double position[3] = {0, 0, 0};  // m
  double velocity[3] = {0, 0, 0};  // m/s
  double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  unsigned buttons = 0;
  double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};  // the last written: N, N m
  int watchdog = 0, forces_on = 0, closed = 0, writes = 0;
};
