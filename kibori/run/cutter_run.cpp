// SPDX-License-Identifier: MIT
#include <kibori/run/cutter_run.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/body/cutter.h>

namespace kibori {
namespace {

// Maximum number of ticks of a cutter's feed. At 1000 Hz, these are almost three hours.
constexpr double kMaxCutterTicks = 1e7;

// Adds the ticks of a cutter that moves along its feed. The force acts against the feed and equals
// the work per distance. `area_mm2` is the area of the cut, counted on one side only.
Status trace_cutter(const SceneCutter& with, const BodyList& before, const BodyList& after,
                    double area_mm2, const Scene& scene, Carving& carving) {
  CarveSummary& summary = carving.summary;
  const double kerf = with.cutter.kerf_mm;
  const auto work = [&](uint8_t i) {
    const Material& m = scene.materials[std::min<size_t>(i, scene.materials.size() - 1)];
    return kerf > 0 ? kerf * m.u : m.gc;
  };
  std::vector<std::pair<const Body*, CutProgress>> cuts;
  // Area of the new faces of the bodies that keep their number. A slot has two of them. Where a
  // part was separated, there is only one.
  double bare_mm2 = 0;
  for (const Body& was : before.all) {
    const Body* const is = after.find(was.id);
    if (!is) continue;
    const Vec3 feed = was.pose.frame.transpose() * with.feed;
    cuts.emplace_back(&was, cut_progress(was.model, is->model, feed, work));
    for (const CutProgress::Sample& step : cuts.back().second.steps) bare_mm2 += step.area_mm2;
  }
  const double distance = with.speed_mm_s / scene.rate_hz,
               share = bare_mm2 > 0 ? area_mm2 / bare_mm2 : 0;
  for (const auto& [was, progress] : cuts) {
    const double h = progress.step_mm, all = static_cast<double>(progress.steps.size()) * h;
    if (!(all <= kMaxCutterTicks * distance))
      return Error{"its feed needs too many ticks; use a higher speed"};
    for (int64_t i = 0; static_cast<double>(i) * distance < all; i++) {
      const CutProgress::Sample& step =
          progress.steps[static_cast<size_t>(static_cast<double>(i) * distance / h)];
      ToolTick tick;
      tick.pose = {was->pose.to_world(step.middle_mm), frame_from_axis(-with.feed)};
      tick.motion.tip = tick.pose.tip;
      tick.motion.axis = tick.pose.axis();
      tick.motion.travel = distance * with.feed;
      tick.wrench.force = -(share * step.work_nmm / h) * with.feed;
      tick.removed_mm3 = share * kerf * step.area_mm2 * distance / h;
      summary.ticks++;
      summary.max_force_N =
          std::max(summary.max_force_N, std::sqrt(tick.wrench.force.squaredNorm()));
      carving.trace.push_back({static_cast<double>(summary.ticks) / scene.rate_hz, tick});
    }
  }
  return Ok{};
}

}  // namespace

Status run_cutter(const SceneCutter& with, const BodyList& bodies,
                  const std::function<Result<BodyChange>(const BodyAction&)>& act,
                  const Scene& scene, Carving& carving) {
  BodyAction cut{{}, BodyCut{with.cutter}};
  if (!with.body.empty()) {
    for (const Body& body : bodies.all)
      if (body.name == with.body) cut.bodies.push_back(body.id);
    if (cut.bodies.empty()) return Error{"there is no body '" + sanitize_message(with.body) + "'"};
  }
  const BodyList before = bodies;
  const Result<BodyChange> done = act(cut);
  if (!done) return Error{done.error()};
  carving.summary.removed_mm3 += done.value().removed_mm3;
  if (with.speed_mm_s > 0)
    if (Status traced = trace_cutter(with, before, bodies, done.value().area_mm2, scene, carving);
        !traced)
      return traced;
  if (with.shift_mm == Vec3::Zero()) return Ok{};
  for (const BodyId id : done.value().made) {
    BodyMove move{bodies.find(id)->pose};
    move.pose.tip += with.shift_mm;
    if (const Result<BodyChange> moved = act({{id}, move}); !moved) return Error{moved.error()};
  }
  return Ok{};
}

}  // namespace kibori
