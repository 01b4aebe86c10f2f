// SPDX-License-Identifier: MIT
// Runs a scene: makes the stock, moves the tools tick by tick, and passes the result of each tick
// to the caller.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/run/carving_result.h>
#include <kibori/scene/scene.h>
#include <kibori/body/workbench.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/spring_tool.h>

namespace kibori {

// The tool of one hand after a tick, and the result of the tick.
struct CarvedTick {
  const Tool& tool;
  Pose pose;
  const ToolTick& result;
};

// Options of carve().
struct CarveOptions {
  int threads = 1;                                  // does not change the result
  bool force = false;                               // see StockOptions::force
  std::filesystem::path document;                   // a new document of the carving; empty: none
  bool keep_forces = false;                         // also store the forces in the document
  std::function<void(double share)> progress;       // 0..1, every 64 ticks and at the end
  std::function<void(const std::string&)> warning;  // called with one sentence for each warning
  // Called after every tick. `second` is null if there is no second hand. It returns false to stop
  // the run.
  std::function<bool(const TriDexel&, const CarvedTick& first, const CarvedTick* second)> each;
};

// Makes the stock and runs the scene. Errors: those of make_stock; a move, a body, a spline or a
// cutter is invalid; a tool is too large for the pitch; the ticks need too much memory; the
// document cannot be created.
Result<Carving> carve(const Scene& scene, const CarveOptions& options);
// Like above, with a stock that make_stock has made.
Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options);
}  // namespace kibori
