// SPDX-License-Identifier: MIT
// Measures the servo loop in real time. A simulated hand scrapes a block with a ball and a finger.
// Radii are 16, 32 and 64 cells. The depth is half the radius. Another thread updates the surface.
//
//   servo_bench [--json] [--quick] [--seconds S]    S per run (six runs), 10 by default, quick 0.5
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <kibori/base/percent.h>
#include <kibori/run/servo_run.h>

namespace {

using namespace kibori;

Scene scrape(const Tool& tool, double depth_mm) {
  Scene scene;
  scene.file = "servo_bench";
  scene.stock.shape = StockBlock{Vec3(120, 120, 60)};
  scene.stock.pitch_mm = 0.25;
  scene.stock.room_mm = 2;
  scene.tools = {tool};
  Material wood;
  wood.u = 0.02;
  wood.yield_n = 0.05;
  scene.materials = {wood};
  Move start;
  start.to_mm = Vec3(10, 10, 61);
  scene.moves = {start};
  for (int row = 0; row <= 20; row++)
    for (const bool back : {false, true}) {
      Move move;
      move.to_mm = Vec3((row % 2 == 1) != back ? 110 : 10, 10 + 5 * row, 60 - depth_mm);
      move.speed_mm_s = 100;
      scene.moves.push_back(move);
    }
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  double seconds = 0;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0) json = true;
    if (std::strcmp(argv[i], "--quick") == 0) quick = true;
    if (std::strcmp(argv[i], "--seconds") == 0 && i + 1 < argc) seconds = std::atof(argv[++i]);
  }
  if (seconds == 0) seconds = quick ? 0.5 : 10;
  std::string out;
  std::string thread;
  for (const bool finger : {false, true})
    for (const int cells : {16, 32, 64}) {
      const double radius = 0.25 * cells;
      // At this depth, the finger's radius equals the ball's radius.
      const Tool tool = finger ? Tool(Finger{1 / (2 * radius), 60}) : Tool(BallTool{radius});
      ServoRunOptions options;
      options.seconds = seconds;
      options.model = ForceModel::series;
      options.stiffness_n_mm = 1.5;
      const auto run = run_servo(scrape(tool, radius / 2), nullptr, options);
      if (!run) return std::fprintf(stderr, "servo_bench: %s\n", run.error().c_str()), 2;
      const ServoReport& r = run.value();
      const auto us = [](const Histogram& h, double share) {
        return static_cast<double>(h.quantile_ns(share)) / 1000;
      };
      const double missed = static_cast<double>(r.servo.missed) /
                            static_cast<double>(r.servo.ticks + r.servo.missed),
                   cutting = static_cast<double>(r.totals.cutting_ticks) /
                             static_cast<double>(r.servo.ticks);
      // Fractions for programs, percent for people.
      const auto share_text = [&](double share, int decimals) {
        if (!json) return percent(share);
        char number[32];
        std::snprintf(number, sizeof number, "%.*f", decimals, share);
        return std::string(number);
      };
      char text[600];
      std::snprintf(
          text, sizeof text,
          json ? "%s{\"tool\":\"%s\",\"radius_cells\":%d,\"compute_p50_us\":%.1f,\"compute_p99_"
                 "us\":%.1f,"
                 "\"compute_p999_us\":%.1f,\"compute_max_us\":%.1f,\"missed\":%s,\"late_p99_us\":%."
                 "1f,"
                 "\"empty_late_p99_us\":%.1f,\"cutting_share\":%s,\"surface_chunks\":%llu}"
               : "%s%-6s R = %d: tick p50 %.1f, p99 %.1f, p99.9 %.1f, max %.1f us; missed %s; late "
                 "p99 "
                 "%.1f us "
                 "(empty loop %.1f); %s of the ticks cut; %llu chunks of surface\n",
          json && !out.empty() ? ",\n " : "", finger ? "finger" : "ball", cells,
          us(r.servo.compute_ns, 0.5), us(r.servo.compute_ns, 0.99), us(r.servo.compute_ns, 0.999),
          static_cast<double>(r.servo.compute_ns.max_ns()) / 1000, share_text(missed, 5).c_str(),
          us(r.servo.late_ns, 0.99), us(r.empty_late_ns, 0.99), share_text(cutting, 3).c_str(),
          static_cast<unsigned long long>(r.surface_chunks));
      out += text;
      thread = r.scheduling;
    }
  if (!json) std::printf("%s\n", thread.c_str());
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
