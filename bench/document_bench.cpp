// SPDX-License-Identifier: MIT
// An hour of carving as a document: 10 000 strokes of 0.36 s in a lattice of 1024^3. What a stroke
// takes on disk and in memory, how long saving, undo, redo and opening take.
//
//   document_bench [--json] [--quick] [--strokes N] [--nodes N]     quick: 20 strokes in 512^3
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <kibori/document/document.h>
#include <kibori/motion/direct_tool.h>

#include "bench/workload.h"

namespace {

using namespace kibori;
using namespace kibori_bench;

double resident_mb() {
  std::ifstream status("/proc/self/statm");
  long total = 0, resident = 0;
  status >> total >> resident;
  return static_cast<double>(resident) * 4096 / 1e6;
}

double share(std::vector<double> v, double below) {
  if (v.empty()) return 0;
  const auto at =
      v.begin() + static_cast<std::ptrdiff_t>(below * static_cast<double>(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  return *at;
}
double largest(const std::vector<double>& v) {
  return v.empty() ? 0 : *std::max_element(v.begin(), v.end());
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  int strokes = 0, nodes = 0;  // 0: as usual
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0) json = true;
    if (std::strcmp(argv[i], "--quick") == 0) quick = true;
    if (std::strcmp(argv[i], "--strokes") == 0 && i + 1 < argc) strokes = std::atoi(argv[++i]);
    if (std::strcmp(argv[i], "--nodes") == 0 && i + 1 < argc) nodes = std::atoi(argv[++i]);
  }
  if (strokes == 0) strokes = quick ? 20 : 10000;
  if (nodes == 0) nodes = quick ? 512 : 1024;
  char folder[] = "/tmp/kibori-bench-XXXXXX";
  if (!mkdtemp(folder)) return 2;
  const std::filesystem::path file = std::filesystem::path(folder) / "hour.kibori";
  const double pitch = 0.1, size = nodes * pitch;
  TriDexel model(make_lattice(Vec3::Constant(size), pitch, 0).value());
  model.fill_block({Vec3::Zero(), Vec3::Constant(size)}, 0);
  model.reserve(4096);
  auto made = Document::create(file, model, "{}");
  if (!made) return std::fprintf(stderr, "document_bench: %s\n", made.error().c_str()), 2;
  Document& document = *made.value();
  const double memory_before = resident_mb();
  std::vector<double> finish_ms, flush_ms, undo_ms, redo_ms;
  StrokeSettings settings;
  settings.tool = BallTool{1.2};
  constexpr int kTicks = 360;
  double carve_us = 0;
  for (int s = 0; s < strokes; s++) {
    // 36 mm, gently curved, somewhere on the top.
    const double a = 2.4 * s, reach = size / 2 - 24;
    Vec3 tip(size / 2 + reach * std::sin(0.7 * s) * std::cos(a),
             size / 2 + reach * std::sin(1.3 * s) * std::sin(a), size - 0.4);
    const Pose start{tip, Mat3::Identity()};
    if (!document.begin(settings, start)) return 2;
    DirectTool stroke(model, start);
    for (int i = 0; i < kTicks; i++) {
      const double turn = a + 0.004 * i, noise = 1e-4 * std::sin(917.0 * i);
      MoveTick tick;
      tip += Vec3(0.1 * std::cos(turn) + noise, 0.1 * std::sin(turn) - noise,
                  5e-4 * std::sin(0.05 * i));
      tick.tip = tip;
      tick.edits = true;
      tick.stretch_mm = Vec3(0.01 * std::sin(313.0 * i), noise, -0.2);
      const double from = now_us();
      if (!stroke.advance(settings.tool, tip, Vec3::Zero(), Mode::cut, {}, settings.materials))
        return 2;
      carve_us += now_us() - from;
      document.add({tick});
      if (i % 50 == 49) {
        const double at = now_us();
        if (!document.flush()) return 2;
        flush_ms.push_back((now_us() - at) / 1000);
      }
    }
    const double at = now_us();
    if (!document.finish(model, 0)) return 2;
    finish_ms.push_back((now_us() - at) / 1000);
  }
  const double memory_kb = (resident_mb() - memory_before) * 1000 / strokes;
  // All the way back and forth again: the states in memory are soon used up.
  const uint64_t first = document.steps().begin()->second.hash;
  const auto all_the_way = [&](Document& through, TriDexel& on, bool back,
                               std::vector<double>& ms) {
    for (int i = 0; i < strokes; i++) {
      const double at = now_us();
      if (!(back ? through.undo(on) : through.redo(on))) return false;
      ms.push_back((now_us() - at) / 1000);
    }
    return true;
  };
  const uint64_t hash = model.content_hash();
  if (!all_the_way(document, model, true, undo_ms) || model.content_hash() != first ||
      !all_the_way(document, model, false, redo_ms) || model.content_hash() != hash)
    return std::fprintf(stderr, "document_bench: undone and redone it is not the same\n"), 2;
  made.value().reset();
  const double disk_kb = static_cast<double>(std::filesystem::file_size(file)) / 1000 / strokes;
  double at = now_us();
  auto opened = Document::open(file, Document::Access::write);
  if (!opened) return 2;
  auto loaded = opened.value()->load();
  const double open_s = (now_us() - at) / 1e6;
  if (!loaded || loaded.value()->content_hash() != hash)
    return std::fprintf(stderr, "document_bench: not the same\n"), 2;
  // With nothing in memory but the end.
  std::vector<double> cold_ms;
  if (!all_the_way(*opened.value(), *loaded.value(), true, cold_ms) ||
      loaded.value()->content_hash() != first)
    return std::fprintf(stderr, "document_bench: undone after opening it is not the same\n"), 2;
  if (!std::getenv("KIBORI_KEEP")) std::filesystem::remove_all(folder);
  std::printf(json ? "{\"strokes\":%d,\"nodes\":%d,\"disk_kb_per_stroke\":%.2f,\"memory_kb_per_"
                     "stroke\":%.2f,\"carve_"
                     "us_per_tick\":%.2f,\"flush_ms\":%.3f,\"flush_max_ms\":%.1f,\"finish_ms\":%."
                     "3f,\"finish_max_"
                     "ms\":%.1f,"
                     "\"undo_ms\":%.3f,\"undo_p99_ms\":%.2f,\"undo_max_ms\":%.1f,"
                     "\"redo_ms\":%.3f,\"redo_p99_ms\":%.2f,\"redo_max_ms\":%.1f,\"open_s\":%.2f,"
                     "\"cold_undo_ms\":%.3f,\"cold_undo_p99_ms\":%.2f,\"cold_undo_max_ms\":%.1f}\n"
                   : "%d strokes in %d^3: %.2f kB of disk and %.2f kB of memory a stroke; carving "
                     "%.2f us a tick\n"
                     "saving 50 ms of a stroke %.3f ms (at most %.1f), finishing one %.3f ms (at "
                     "most %.1f)\n"
                     "undo of every stroke %.3f ms (p99 %.2f, at most %.1f), redo %.3f ms (p99 "
                     "%.2f, at most %.1f)\n"
                     "opening and loading %.2f s; undo of every stroke then %.3f ms (p99 %.2f, at "
                     "most %.1f)\n",
              strokes, nodes, disk_kb, memory_kb, carve_us / strokes / kTicks, median(flush_ms),
              largest(flush_ms), median(finish_ms), largest(finish_ms), median(undo_ms),
              share(undo_ms, 0.99), largest(undo_ms), median(redo_ms), share(redo_ms, 0.99),
              largest(redo_ms), open_s, median(cold_ms), share(cold_ms, 0.99), largest(cold_ms));
}
