// SPDX-License-Identifier: MIT
// Measures reshaping of a ball 300 cells across.
// - Smoothing: dabs around the ball, a quarter of the brush's radius apart, on one thread and on
//   two. The peer smooths its level set of the same region in place.
// - Clay: a ball tool pressed into the ball along the same path. Each tick returns material once.
//   The collar reaches as far as the brush.
// - Grabbing: the surface pulled by 0.3 radii, each time in another direction. The first time
//   includes reading the surface. On one thread and on two.
// - Undo: back to the snapshot before a dab or a grab.
//
//   reshape_bench [--json] [--quick]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include <kibori/edit/edit.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/reshape/warp.h>
#include <kibori/solid/ball.h>

#include "bench/workload.h"
#ifdef KIBORI_HAVE_OPENVDB
#include "bench/peers/openvdb_smooth.h"
#endif

namespace {

using namespace kibori;
using namespace kibori_bench;

constexpr double kSigma = 2;  // [cells]

std::vector<Point> dab_path(double ball, double brush, int dabs) {
  std::vector<Point> path;
  for (int i = 0; i < dabs; i++) {
    const double angle = 0.25 * brush / ball * i;
    path.push_back({static_cast<float>(ball * 0.8 * std::cos(angle)),
                    static_cast<float>(ball * 0.8 * std::sin(angle)),
                    static_cast<float>(ball * 0.6)});
  }
  return path;
}

struct DabTimes {
  std::vector<double> dab, undo;  // [ms]
  double removed = 0;             // [cells]
};

// Runs `f` and appends its time.
template <class F>
void timed(std::vector<double>& ms, F&& f) {
  const double start = now_us();
  f();
  ms.push_back((now_us() - start) / 1000);
}

// Ends the benchmark on an error.
template <class Done>
void check(const Done& done) {
  if (done.ok()) return;
  std::fprintf(stderr, "reshape_bench: %s\n", done.error().c_str());
  std::exit(1);
}

DabTimes time_dabs(TriDexel& model, Reshaper& reshaper, const Vec3& middle,
                   const std::vector<Point>& path, double radius, int threads) {
  DabTimes times;
  reshaper.set_threads(threads);
  const Brush brush{.radius_mm = radius, .strength = 1, .sigma_mm = kSigma};
  for (const Point& at : path) {
    const Vec3 centre = middle + Vec3(static_cast<double>(at.x), static_cast<double>(at.y),
                                      static_cast<double>(at.z));
    const Snapshot before = model.snapshot();  // like a state kept for undo
    timed(times.dab, [&] {
      const Result<Reshaped> done = reshaper.dab(model, FieldVerb::smooth, brush, centre);
      check(done);
      times.removed += done.value().removed_mm3;
    });
    const Snapshot after = model.snapshot();
    timed(times.undo, [&] { model.restore(before); });
    model.restore(after);
  }
  return times;
}

std::vector<double> time_clay(TriDexel& model, const std::shared_ptr<DabMemory>& memory,
                              const Vec3& middle, double ball, double radius, int steps,
                              int threads) {
  std::vector<double> ms;
  const ReshapeSettings settings{.mode = Mode::press, .tool = BallTool{radius / 2.5}};
  const std::vector<Material> materials(1);
  const auto pose_at = [&](int step) {
    const double angle = 0.1 * radius / ball * step;
    const Vec3 out(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.6);
    return Pose{middle + (ball - 0.1 * radius) * out, frame_from_axis(out, 0)};
  };
  ReshapeStroke stroke(model, memory);
  stroke.set_threads(threads);
  Pose last = pose_at(0);
  check(stroke.begin(settings, materials, last));
  for (int i = 1; i <= steps; i++) {
    const Pose pose = pose_at(i);
    const ToolMotion motion{last, pose.tip - last.tip, rotation_between(last.frame, pose.frame)};
    const Snapshot before = model.snapshot();
    ToolTick tick;
    tick.pose = pose;
    tick.motion = {pose.tip, pose.axis(), motion.travel_mm, motion.turn_rad};
    timed(ms, [&] { check(stroke.advance(tick)); });
    last = pose;
  }
  return ms;
}

struct GrabTimes {
  std::vector<double> first, update, undo;  // [ms]
};

GrabTimes time_grabs(TriDexel& model, const Vec3& middle, double ball, double radius, bool quick,
                     int threads) {
  GrabTimes times;
  for (int stroke = 0; stroke < (quick ? 1 : 5); stroke++) {
    const double angle = 0.4 * stroke;
    Drag drag;
    drag.axis = drag.normal = Vec3(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.6);
    drag.centre = middle + ball * drag.normal;
    const Snapshot before = model.snapshot();
    Warp warp(model);
    warp.set_threads(threads);
    for (int i = 0; i < (quick ? 3 : 20); i++) {
      drag.displacement = 0.3 * radius * Vec3(std::cos(i), std::sin(i), 0.5).normalized();
      timed(i == 0 ? times.first : times.update, [&] {
        check(warp.warp(WarpVerb::grab, {.radius_mm = radius, .strength = 1}, {drag}));
      });
    }
    timed(times.undo, [&] { model.restore(before); });
  }
  return times;
}

// The times of one brush radius.
struct RadiusTimes {
  double radius;                                       // [cells]
  std::vector<double> dabs, dabs2, clay, clay2, undo;  // [ms]; 2: on two threads
  GrabTimes grabs, grabs2;
  double removed_cells = 0;
  double peer_ms = 0;
};

std::string report(const RadiusTimes& t, bool json) {
  char text[1100];
  std::snprintf(
      text, sizeof text,
      json ? "{\"radius_cells\":%g,\"sigma_cells\":%g,\"dab_p50_ms\":%.2f,"
             "\"dab_p99_ms\":%.2f,\"dab_2_threads_p50_ms\":%.2f,"
             "\"dab_2_threads_p99_ms\":%.2f,\"removed_cells\":%.0f,"
             "\"openvdb_ms\":%.2f,\"ratio\":%.2f,\"clay_p50_ms\":%.2f,\"clay_p99_ms\":%.2f,"
             "\"clay_2_threads_p50_ms\":%.2f,\"clay_2_threads_p99_ms\":%.2f,\"grab_first_p50_ms\":"
             "%.2f,"
             "\"grab_p50_ms\":%.2f,\"grab_p99_ms\":%.2f,\"grab_2_threads_first_p50_ms\":%.2f,"
             "\"grab_2_threads_p50_ms\":%.2f,\"grab_2_threads_p99_ms\":%.2f,"
             "\"undo_p99_ms\":%.3f},\n "
           : "R = %g, sigma %g: dab p50 %.2f ms, p99 %.2f ms, on two threads %.2f and %.2f ms; "
             "%.0f "
             "cells removed in all; OpenVDB %.2f ms, ratio %.2f; clay p50 %.2f ms, p99 %.2f ms, "
             "on two threads %.2f and %.2f ms; grab first %.2f ms, then p50 %.2f ms, p99 %.2f ms, "
             "on two threads %.2f, %.2f and %.2f ms; undo p99 %.3f ms\n",
      t.radius, kSigma, median(t.dabs), percentile(t.dabs, 0.99), median(t.dabs2),
      percentile(t.dabs2, 0.99), t.removed_cells, t.peer_ms, t.peer_ms / median(t.dabs),
      median(t.clay), percentile(t.clay, 0.99), median(t.clay2), percentile(t.clay2, 0.99),
      median(t.grabs.first), median(t.grabs.update), percentile(t.grabs.update, 0.99),
      median(t.grabs2.first), median(t.grabs2.update), percentile(t.grabs2.update, 0.99),
      percentile(t.undo, 0.99));
  return text;
}

RadiusTimes time_radius(const Lattice& lattice, double ball, double radius, bool quick) {
  const Vec3 middle = 0.5 * lattice.nodes.matrix().cast<double>();
  const auto path = dab_path(ball, radius, quick ? 3 : 60);
  TriDexel model(lattice);
  Removed removed;
  deposit(model, SweptBall(LatticePoint{middle}, LatticeVector(), ball), 0, {}, removed);
  const Snapshot start = model.snapshot();
  const int presses = quick ? 3 : 60;
  // The first runs below are not timed. They allocate the memory, as earlier strokes do in the
  // studio. A dab that must allocate is slower.
  const auto memory = std::make_shared<DabMemory>();
  const auto dabs_on = [&](int threads) {
    model.restore(start);
    return time_dabs(model, memory->reshaper, middle, path, radius, threads);
  };
  const auto clay_on = [&](int threads) {
    model.restore(start);
    return time_clay(model, memory, middle, ball, radius, presses, threads);
  };
  for (const int threads : {1, 2}) {
    dabs_on(threads);
    clay_on(threads);
  }
  RadiusTimes times;
  times.radius = radius;
  const auto append = [](std::vector<double>& to, const std::vector<double>& more) {
    to.insert(to.end(), more.begin(), more.end());
  };
  // Run several rounds and alternate. The 99th percentile of one round would be its maximum.
  for (int round = 0; round < (quick ? 1 : 5); round++) {
    const DabTimes one = dabs_on(1);
    append(times.dabs, one.dab);
    append(times.undo, one.undo);
    times.removed_cells = one.removed;
    append(times.dabs2, dabs_on(2).dab);
    append(times.clay, clay_on(1));
    append(times.clay2, clay_on(2));
  }
  times.grabs = time_grabs(model, middle, ball, radius, quick, 1);
  times.grabs2 = time_grabs(model, middle, ball, radius, quick, 2);
  append(times.undo, times.grabs.undo);
#ifdef KIBORI_HAVE_OPENVDB
  times.peer_ms =
      median(openvdb_smooth_dabs(static_cast<float>(ball), path, static_cast<float>(radius)).us) /
      1000;
#endif
  return times;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0)
      json = true;
    else if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else {
      std::fprintf(stderr, "reshape_bench: unknown option %s\n", argv[i]);
      return 1;
    }
  }
  const double ball = quick ? 60 : 150;
  Lattice lattice;
  lattice.nodes = Index3::Constant(static_cast<int>(2 * ball) + 40);
  std::string out;
  for (const double radius : {16.0, 32.0, 64.0})
    if (!quick || radius <= 32) out += report(time_radius(lattice, ball, radius, quick), json);
  if (json) out.erase(out.rfind(','));
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
