// SPDX-License-Identifier: MIT
// Runs the servo loop for some time, with a simulated hand or a real device, and reports its
// timing.
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

// Options of run_servo().
struct ServoRunOptions {
  double seconds = 10;
  double rate_hz = 1000;
  std::optional<ForceModel> model;  // default: the model of the scene
  // Default: in the model `series`, that of the scene's spring; otherwise, that of the device.
  std::optional<double> stiffness_n_mm;
  bool surface = true;  // update the surface on the calling thread during the run
  // Run a thread that only wakes at each tick. Its delay shows which part of the servo's delay the
  // machine causes.
  bool empty_loop = true;
  std::filesystem::path record;    // file for the device's readings, which replay:FILE plays
  std::filesystem::path document;  // path of a new document for the carving
  bool keep_forces = false;        // also store the forces in the document
  // `begins` is called once before the first tick. During the run, `on_ticks` gets every tick,
  // several at a time.
  std::function<void(const std::string& device, const Lattice& lattice)> begins;
  std::function<void(const std::vector<LiveTick>& ticks)> on_ticks;
  std::function<void(double share)> progress;
  // Called every few milliseconds. If it returns true, the run ends early.
  std::function<bool()> cancelled;
};

// The result of run_servo(): timing, totals and faults.
struct ServoReport {
  std::string device, scheduling;
  double rate_hz = 0;
  ServoStatistics servo;
  Histogram empty_late_ns;
  LiveTotals totals;
  Trip trip = Trip::none;
  // Minimum of the hand's energy balance. Below 0: the hand got more energy back than it gave.
  double min_energy_mj = 0;
  uint64_t snapshots = 0, surface_chunks = 0;
  uint64_t left_out = 0;  // number of readings for which the recording had no room
  // The error message of the device, or empty.
  std::string complaint;
  // The reason why the document lacks the last steps, and the place where they are. Empty if the
  // document is complete.
  std::string unsaved;
};

// Runs the scene's first tool on its stock. The mode is that of the scene's first move with a mode
// other than `off`. If `device` is null, a virtual device is used, whose hand moves back and forth
// along the scene's moves. Errors: those of make_stock, plan_move and LiveCarving::make; the scene
// has a part that a servo run does not support; the document or the recording cannot be written.
Result<ServoReport> run_servo(const Scene& scene, std::unique_ptr<Device> device,
                              const ServoRunOptions& options);

// Returns the default scene: a ball that scrapes back and forth over a block of oak.
Scene servo_scene();

// Return the report as text for the terminal, and as JSON.
std::string servo_report_text(const ServoReport& report);
std::string servo_report_json(const ServoReport& report);

}  // namespace kibori
