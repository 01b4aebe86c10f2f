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

// A tick as it was felt.
struct TraceRow {
  double time_s = 0;  // at the end of the tick
  ToolTick result;
  std::shared_ptr<const ToolTick> second = nullptr;  // of the second hand, where there is one
};

// A labelled place on the path.
struct Mark {
  std::string label;
  double time_s = 0;
};

struct CarveSummary {
  int64_t ticks = 0;
  // removed: by tools and kerfs. fallen: what was severed and fell away. volume: of all bodies that
  // are not no-go, as bodies counts them.
  double removed_mm3 = 0, deposited_mm3 = 0, fallen_mm3 = 0, volume_mm3 = 0;
  size_t bodies = 1;
  int64_t points_removed = 0;
  double max_force_N = 0, max_moment_Nmm = 0;
  uint64_t state_hash = 0;
  struct {
    double median = 0, p99 = 0, p999 = 0, max = 0;
  } step_us;  // edit and wrench of one tick
  double pitch_mm = 0;
  ModelCount stock;
};

struct Carving {
  std::unique_ptr<TriDexel> model;  // of the body that was worked on last
  Bodies bodies;                    // all of them
  std::vector<TraceRow> trace;
  std::vector<Mark> marks;
  CarveSummary summary;
  // Why the document holds only the beginning, and where the rest is; empty: all is there.
  std::string unsaved;
};

// Errors: those of make_stock; what a move can't be.
Result<Carving> carve(const Scene& scene, const CarveOptions& options);
// As above, of a stock that make_stock made.
Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options);
// Counts what a hand did in a tick; what was touched only was not removed.
void add_tick(CarveSummary& summary, Mode mode, ToolTick& result);
// Fills in what of a summary comes from the model and the times of its steps.
void summarize(Carving& carving, std::vector<double> step_us);

}  // namespace kibori
