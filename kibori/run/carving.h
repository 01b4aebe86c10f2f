// SPDX-License-Identifier: MIT
// Runs a scene: makes the stock, moves the tool tick by tick, and passes each tick's result to the
// caller.
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

// State of one hand's tool after a tick, and the tick's result.
struct CarvedTick {
  const Tool& tool;
  Pose pose;
  const ToolTick& result;
};

// Options of carve().
struct CarveOptions {
  int threads = 1;                                  // does not change the result
  bool force = false;                               // see StockOptions::force
  std::filesystem::path document;                   // written during carving; empty: none
  bool keep_forces = false;                         // also store forces in the document
  std::function<void(double share)> progress;       // 0..1, every 64 ticks and at the end
  std::function<void(const std::string&)> warning;  // one sentence per call
  // Called after every tick. `second`: of the second hand; null if there is none. Returns false to
  // stop the run.
  std::function<bool(const TriDexel&, const CarvedTick& first, const CarvedTick* second)> each;
};

// Makes the stock and runs the scene. Errors: those of make_stock; an invalid move, body, spline or
// cutter; a tool too large for the pitch; too many ticks for the memory; a document that cannot be
// created.
Result<Carving> carve(const Scene& scene, const CarveOptions& options);
// The same on a stock that make_stock has made.
Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options);
}  // namespace kibori
