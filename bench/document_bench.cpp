// SPDX-License-Identifier: MIT
// Measures a document after an hour of carving: 10 000 strokes of 0.36 s in a lattice of 1024^3
// nodes. Reports the disk and memory per stroke, and the times of saving, undo, redo and opening.
//
//   document_bench [--json] [--quick] [--strokes N] [--nodes N]
//
// --quick means 20 strokes in 512^3 nodes.
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

// Returns the value that is not exceeded by the share `below` of all values in v.
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

struct Options {
  bool json = false, quick = false;
  int strokes = 0, nodes = 0;
};

Options options_of(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0) options.json = true;
    if (std::strcmp(argv[i], "--quick") == 0) options.quick = true;
    if (std::strcmp(argv[i], "--strokes") == 0 && i + 1 < argc)
      options.strokes = std::atoi(argv[++i]);
    if (std::strcmp(argv[i], "--nodes") == 0 && i + 1 < argc) options.nodes = std::atoi(argv[++i]);
  }
  if (options.strokes == 0) options.strokes = options.quick ? 20 : 10000;
  if (options.nodes == 0) options.nodes = options.quick ? 512 : 1024;
  return options;
}

constexpr double kPitch = 0.1;  // [mm]
constexpr int kTicks = 360;     // number of ticks per stroke

struct Times {
  std::vector<double> finish_ms, flush_ms, undo_ms, redo_ms;
  std::vector<double> cold_ms;  // undo after opening, when only the last state is in memory
  double carve_us = 0, open_s = 0;
  double disk_kb = 0, memory_kb = 0;  // per stroke
};

// Carves a stroke of 36 mm along a gentle curve on the top, and stores it. Returns false if this
// failed.
bool carve_stroke(Document& document, TriDexel& model, int number, double size, Times& times) {
  StrokeSettings settings;
  settings.tool = BallTool{1.2};
  const double a = 2.4 * number, reach = size / 2 - 24;
  Vec3 tip(size / 2 + reach * std::sin(0.7 * number) * std::cos(a),
           size / 2 + reach * std::sin(1.3 * number) * std::sin(a), size - 0.4);
  const Pose start{tip, Mat3::Identity()};
  if (!document.begin(settings, start)) return false;
  DirectTool stroke(model, start);
  for (int i = 0; i < kTicks; i++) {
    const double turn = a + 0.004 * i, noise = 1e-4 * std::sin(917.0 * i);
    MoveTick tick;
    tip +=
        Vec3(0.1 * std::cos(turn) + noise, 0.1 * std::sin(turn) - noise, 5e-4 * std::sin(0.05 * i));
    tick.tip = tip;
    tick.edits = true;
    tick.stretch_mm = Vec3(0.01 * std::sin(313.0 * i), noise, -0.2);
    const double from = now_us();
    if (!stroke.advance(settings.tool, tip, Vec3::Zero(), Mode::cut, {}, settings.materials))
      return false;
    times.carve_us += now_us() - from;
    document.add({tick});
    if (i % 50 == 49) {
      const double at = now_us();
      if (!document.flush()) return false;
      times.flush_ms.push_back((now_us() - at) / 1000);
    }
  }
  const double at = now_us();
  if (!document.finish(model, 0)) return false;
  times.finish_ms.push_back((now_us() - at) / 1000);
  return true;
}

// Undoes all strokes, one by one, and appends the time of each to `ms`. Returns false on failure.
bool undo_all(Document& document, TriDexel& model, int strokes, std::vector<double>& ms) {
  for (int i = 0; i < strokes; i++) {
    const double at = now_us();
    if (!document.undo(model)) return false;
    ms.push_back((now_us() - at) / 1000);
  }
  return true;
}
bool redo_all(Document& document, TriDexel& model, int strokes, std::vector<double>& ms) {
  for (int i = 0; i < strokes; i++) {
    const double at = now_us();
    if (!document.redo(model)) return false;
    ms.push_back((now_us() - at) / 1000);
  }
  return true;
}

int fail(const std::string& why) {
  std::fprintf(stderr, "document_bench: %s\n", why.c_str());
  return 2;
}

// Measures a new document at `file`. Returns the exit status of the program.
int measure(const std::filesystem::path& file, const Options& options, Times& times) {
  const double size = options.nodes * kPitch;
  const int strokes = options.strokes;
  TriDexel model(make_lattice(Vec3::Constant(size), kPitch, 0).value());
  model.fill_block({Vec3::Zero(), Vec3::Constant(size)}, 0);
  model.reserve(4096);
  auto made = Document::create(file, model, "{}");
  if (!made) return fail(made.error());
  Document& document = *made.value();
  const double memory_before = resident_mb();
  for (int s = 0; s < strokes; s++)
    if (!carve_stroke(document, model, s, size, times)) return 2;
  times.memory_kb = (resident_mb() - memory_before) * 1000 / strokes;
  // Undoes everything, then redoes it. Only the newest states are in memory.
  const uint64_t first = document.steps().begin()->second.hash;
  const uint64_t hash = model.content_hash();
  if (!undo_all(document, model, strokes, times.undo_ms) || model.content_hash() != first ||
      !redo_all(document, model, strokes, times.redo_ms) || model.content_hash() != hash)
    return fail("undone and redone it is not the same");
  made.value().reset();
  times.disk_kb = static_cast<double>(std::filesystem::file_size(file)) / 1000 / strokes;
  const double at = now_us();
  auto opened = Document::open(file, Document::Access::write);
  if (!opened) return 2;
  auto loaded = opened.value()->load();
  times.open_s = (now_us() - at) / 1e6;
  if (!loaded || loaded.value()->content_hash() != hash) return fail("not the same");
  if (!undo_all(*opened.value(), *loaded.value(), strokes, times.cold_ms) ||
      loaded.value()->content_hash() != first)
    return fail("undone after opening it is not the same");
  return 0;
}

void print(const Options& options, const Times& times) {
  std::printf(
      options.json ? "{\"strokes\":%d,\"nodes\":%d,\"disk_kb_per_stroke\":%.2f,\"memory_kb_per_"
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
      options.strokes, options.nodes, times.disk_kb, times.memory_kb,
      times.carve_us / options.strokes / kTicks, median(times.flush_ms), largest(times.flush_ms),
      median(times.finish_ms), largest(times.finish_ms), median(times.undo_ms),
      share(times.undo_ms, 0.99), largest(times.undo_ms), median(times.redo_ms),
      share(times.redo_ms, 0.99), largest(times.redo_ms), times.open_s, median(times.cold_ms),
      share(times.cold_ms, 0.99), largest(times.cold_ms));
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = options_of(argc, argv);
  char folder[] = "/tmp/kibori-bench-XXXXXX";
  if (!mkdtemp(folder)) return 2;
  Times times;
  if (const int status = measure(std::filesystem::path(folder) / "hour.kibori", options, times);
      status != 0)
    return status;
  if (!std::getenv("KIBORI_KEEP")) std::filesystem::remove_all(folder);
  print(options, times);
}
