// SPDX-License-Identifier: MIT
// Runs a scene: makes the stock, then moves the tool tick by tick and hands each tick's result to
// the caller.
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

// What a hand's tool came to in a tick.
struct CarvedTick {
  const Tool& tool;
  Pose pose;
  const ToolTick& result;
};

struct CarveOptions {
  int threads = 1;                                  // results do not depend on it
  bool force = false;                               // take a mesh whose rays mostly disagree
  std::filesystem::path document;                   // written as it is carved; empty: none
  bool keep_forces = false;                         // in the document, too
  std::function<void(double share)> progress;       // 0..1, now and then
  std::function<void(const std::string&)> warning;  // one sentence each
  // After every tick; second: the second hand's, or null. false: no more of them.
  std::function<bool(const TriDexel&, const CarvedTick& first, const CarvedTick* second)> each;
};

// Errors: those of make_stock; what a move can't be.
Result<Carving> carve(const Scene& scene, const CarveOptions& options);
// As above, of a stock that make_stock made.
Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options);
}  // namespace kibori
