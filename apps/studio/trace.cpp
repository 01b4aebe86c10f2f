// SPDX-License-Identifier: MIT
#include "apps/studio/trace.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <nlohmann/json.hpp>

#include "apps/studio/wire.h"

namespace kibori::studio {
namespace {

constexpr size_t kMaxRows = 100000;

}  // namespace

Trace trace_of(const ExperimentSession& run, const Carving& carving) {
  const CarveSummary& summary = carving.summary;
  nlohmann::json marks = nlohmann::json::array();
  for (const Mark& mark : carving.marks)
    marks.push_back({{"label", mark.label}, {"time_s", mark.time_s}});
  double sum = 0;
  int64_t with_force = 0;
  for (const TraceRow& row : carving.trace) {
    const double force = std::sqrt(row.result.wrench.force.squaredNorm());
    sum += force;
    with_force += force > 0;
  }
  const Scene& scene = run.scene();
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  Trace trace;
  trace.json = nlohmann::json{
      {"run", std::chrono::duration_cast<std::chrono::milliseconds>(now).count()},
      {"name", scene.file},
      {"mean_force_N", with_force > 0 ? sum / static_cast<double>(with_force) : 0.0},
      {"model", name_of(scene.force.law.model)},
      {"finished", run.share() >= 1 && !run.stopped()},
      {"ticks", summary.ticks},
      {"removed_mm3", summary.removed_mm3},
      {"max_force_N", summary.max_force_N},
      {"max_moment_Nmm", summary.max_moment_Nmm},
      {"step_us", summary.step_us.median},
      {"marks",
       marks}}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const size_t each = (carving.trace.size() + kMaxRows - 1) / kMaxRows;
  Writer rows;
  for (size_t i = 0; i < carving.trace.size(); i += each) {
    const TraceRow* max = &carving.trace[i];
    for (size_t j = i; j < std::min(i + each, carving.trace.size()); j++)
      if (carving.trace[j].result.wrench.force.squaredNorm() >
          max->result.wrench.force.squaredNorm())
        max = &carving.trace[j];
    rows.put(static_cast<float>(max->time_s));
    for (const Vec3& v : {max->result.wrench.force, max->result.wrench.moment})
      for (int k = 0; k < 3; k++) rows.put(static_cast<float>(v[k]));
  }
  trace.data = rows.take();
  return trace;
}

}  // namespace kibori::studio
