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

// Result of one hand's tool in a tick.
struct CarvedTick {
  const Tool& tool;
  Pose pose;
  const ToolTick& result;
};

// Options of carve().
struct CarveOptions {
  int threads = 1;                                  // does not change the result
  bool force = false;                               // accept a mesh whose rays mostly disagree
  std::filesystem::path document;                   // written during carving; empty: none
  bool keep_forces = false;                         // also store forces in the document
  std::function<void(double share)> progress;       // 0..1, now and then
  std::function<void(const std::string&)> warning;  // one sentence per call
  // Called after every tick. `second` is the second hand's, or null. Return false to stop.
  std::function<bool(const TriDexel&, const CarvedTick& first, const CarvedTick* second)> each;
};

// Errors: those of make_stock, and invalid moves.
Result<Carving> carve(const Scene& scene, const CarveOptions& options);
// The same for a stock that make_stock made.
Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options);
}  // namespace kibori
