// SPDX-License-Identifier: MIT
// Runs the servo loop for a while with a simulated hand (or a real device) and says how it kept
// time.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/scene/scene.h>
#include <kibori/haptics/servo.h>
#include <kibori/live/live_carving.h>

namespace kibori {

struct ServoRunOptions {
  double seconds = 10;
  double rate_hz = 1000;
  std::optional<ForceModel> model;       // else the scene's
  std::optional<double> stiffness_n_mm;  // else the device's
  bool surface = true;                   // a second thread follows with the surface
  // A thread that only wakes, to tell the machine's jitter from ours.
  bool empty_loop = true;
  std::filesystem::path record;    // keep the device's readings here, for replay:FILE
  std::filesystem::path document;  // keep what is carved here
  bool keep_forces = false;        // and what was felt
  // What is carved, before the first tick; and every tick, some at a time, while others are made.
  std::function<void(const std::string& device, const Lattice& lattice)> begins;
  std::function<void(const std::vector<LiveTick>& ticks)> told;
  std::function<void(double share)> progress;
  // Asked now and then; true ends the run as if the time were over.
  std::function<bool()> cancelled;
};

struct ServoReport {
  std::string device, scheduling;
  double rate_hz = 0;
  ServoStatistics servo;
  Histogram empty_late_ns;
  LiveTotals totals;
  Trip trip = Trip::none;
  double min_energy_mj = 0;  // what the program gave back beyond what it got, at worst
  uint64_t snapshots = 0, surface_chunks = 0;
  uint64_t left_out = 0;  // ticks that the recording had no room for
  // What the device says is wrong; empty: nothing.
  std::string complaint;
  // Why the document holds only the beginning, and where the rest is; empty: all is there.
  std::string unsaved;
};

// Carves the scene's stock (or fills, or only touches, as its first move that is not off) with its
// first tool; the virtual device's hand goes to and fro along the scene's moves. device: null for
// the virtual one. Errors: those of make_stock, plan_move and LiveCarving::make, or a recording
// that can't be written.
Result<ServoReport> run_servo(const Scene& scene, std::unique_ptr<Device> device,
                              const ServoRunOptions& options);

// The scene that is run where none is given: a ball that scrapes to and fro over a block of oak.
Scene servo_scene();

std::string servo_report_text(const ServoReport& report);
std::string servo_report_json(const ServoReport& report);

}  // namespace kibori
