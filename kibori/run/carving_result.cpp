// SPDX-License-Identifier: MIT
#include <kibori/run/carving_result.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace kibori {
namespace {

double percentile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto at = static_cast<size_t>(share * static_cast<double>(sorted.size()));
  return sorted[std::min(sorted.size() - 1, at)];
}

}  // namespace

void add_tick(CarveSummary& summary, Mode mode, ToolTick& result) {
  if (mode == Mode::touch) result.removed_mm3 = 0;
  if (mode == Mode::cut) {
    summary.removed_mm3 += result.removed_mm3;
    summary.points_removed += result.points;
  }
  if (mode == Mode::deposit) summary.deposited_mm3 -= result.removed_mm3;
  if (reshapes(mode)) {
    summary.removed_mm3 += std::max(0.0, result.removed_mm3);
    summary.deposited_mm3 += std::max(0.0, -result.removed_mm3);
  }
  summary.max_force_N = std::max(summary.max_force_N, std::sqrt(result.wrench.force.squaredNorm()));
  summary.max_moment_Nmm =
      std::max(summary.max_moment_Nmm, std::sqrt(result.wrench.moment.squaredNorm()));
}

void summarize(Carving& carving, std::vector<double> step_us) {
  CarveSummary& summary = carving.summary;
  const TriDexel& model = *carving.model;
  summary.volume_mm3 = 0;
  summary.bodies = 0;
  for (const Body& body : carving.bodies.all) {
    if (body.no_go) continue;
    summary.volume_mm3 += body.model.volume_mm3();
    summary.bodies++;
  }
  summary.state_hash = carving.bodies.content_hash();
  summary.pitch_mm = model.lattice().pitch_mm;
  summary.stock = model.count();
  std::sort(step_us.begin(), step_us.end());
  summary.step_us = {percentile(step_us, 0.5), percentile(step_us, 0.99),
                     percentile(step_us, 0.999), step_us.empty() ? 0 : step_us.back()};
}

}  // namespace kibori
