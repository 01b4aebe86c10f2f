// SPDX-License-Identifier: MIT
// Runs the servo loop for some time with a simulated hand or a real device, and reports its timing.
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
  std::optional<ForceModel> model;  // default: the scene's
  // Default: that of the scene's spring in model `series`, otherwise that of the device.
  std::optional<double> stiffness_n_mm;
  bool surface = true;  // the calling thread updates the surface during the run
  // Runs a thread that only wakes up at each tick. It shows how much of the servo's delay is due to
  // the machine.
  bool empty_loop = true;
  std::filesystem::path record;    // file for the device's readings; device replay:FILE plays it
  std::filesystem::path document;  // store the carving in this new document
  bool keep_forces = false;        // also store the forces in it
  // `begins` is called once before the first tick. `on_ticks` gets every tick, in batches, during
  // the run.
  std::function<void(const std::string& device, const Lattice& lattice)> begins;
  std::function<void(const std::vector<LiveTick>& ticks)> on_ticks;
  std::function<void(double share)> progress;
  // Called every few milliseconds. If it returns true, the run ends as if its time were over.
  std::function<bool()> cancelled;
};

// Result of run_servo(): timing, totals and faults.
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
  uint64_t left_out = 0;  // ticks that did not fit into the recording
  // The device's error message; empty if there is none.
  std::string complaint;
  // Why the document holds only the beginning, and where the rest is. Empty if the document is
  // complete.
  std::string unsaved;
};

// Runs the scene's first tool on its stock, in the mode of the scene's first move that is not
// `off`. The virtual device's hand moves back and forth along the scene's moves. A null `device`
// selects the virtual one. Errors: those of make_stock, plan_move and LiveCarving::make; a part of
// the scene that a servo run does not support; a document or recording that cannot be written.
Result<ServoReport> run_servo(const Scene& scene, std::unique_ptr<Device> device,
                              const ServoRunOptions& options);

// The default scene: a ball that scrapes back and forth over a block of oak.
Scene servo_scene();

// The report as text for the terminal, and as JSON.
std::string servo_report_text(const ServoReport& report);
std::string servo_report_json(const ServoReport& report);

}  // namespace kibori
