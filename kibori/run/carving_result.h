// SPDX-License-Identifier: MIT
// The result of carving a scene or of replaying a document: the bodies, all ticks, and totals.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/motion/tool_tick.h>

namespace kibori {

// A tick with its time. The list of all ticks is called trace.
struct TraceRow {
  double time_s = 0;  // at the end of the tick
  ToolTick result;
  std::shared_ptr<const ToolTick> second = nullptr;  // tick of the second hand, or null
};

// A position of the path with a label.
struct Mark {
  std::string label;
  double time_s = 0;
};

// The totals of a carving.
struct CarveSummary {
  int64_t ticks = 0;
  // removed: volume that tools, kerfs and splines removed. fallen: volume of severed pieces that
  // were discarded. volume: volume of all bodies that are not protected. `bodies` is the number of
  // these bodies.
  double removed_mm3 = 0, deposited_mm3 = 0, fallen_mm3 = 0, volume_mm3 = 0;
  size_t bodies = 1;
  // The part of the removed and added volume that caused no force. Above 0 only in the model
  // `energy`. See StrokePlayer::without_force_mm3.
  double without_force_mm3 = 0;
  int64_t points_removed = 0;
  double max_force_N = 0, max_moment_Nmm = 0;
  uint64_t state_hash = 0;
  struct {
    double median = 0, p99 = 0, p999 = 0, max = 0;
  } step_us;  // time to compute the edit and the wrench of a tick
  double pitch_mm = 0;
  ModelCount stock;
};

// The complete result of a carving.
struct Carving {
  std::unique_ptr<TriDexel> model;  // model of the last active body
  BodyList bodies;                  // all bodies
  std::vector<TraceRow> trace;
  std::vector<Mark> marks;
  CarveSummary summary;
  // The reason why the document lacks the last steps, and the place where they are. Empty if the
  // document is complete.
  std::string unsaved;
};

// Adds a tick of one hand to the totals. In the mode `touch`, also sets result.removed_mm3 to 0,
// because a touch removes nothing.
void add_tick(CarveSummary& summary, Mode mode, ToolTick& result);
// Computes the totals that depend on the bodies, and the quantiles of `step_us`. `step_us` has the
// time of each tick.
void summarize(Carving& carving, std::vector<double> step_us);

}  // namespace kibori
