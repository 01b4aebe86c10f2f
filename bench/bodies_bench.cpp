// SPDX-License-Identifier: MIT
// Bodies that come apart, in a cube whose sides were scraped by a hand's strokes: a plane, a line
// drawn by hand and a saw that part it, the two put together again, and what a stroke severs looked
// for at its end, where it severed nothing, a corner, or half of the cube. Splits, and half
// of the cube, on one thread and on two.
//
//   bodies_bench [--json] [--quick] [--only TEXT]     (what has TEXT in its name)
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

#include <kibori/body/bodies.h>
#include <kibori/motion/direct_tool.h>

#include "bench/workload.h"

namespace {

using namespace kibori;
using namespace kibori_bench;

void fail(const std::string& error) {
  std::fprintf(stderr, "bodies_bench: %s\n", error.c_str());
  std::exit(1);
}

void stroke(TriDexel& model, const Tool& tool, const Vec3& from, const Vec3& to, int ticks) {
  DirectTool hand(model, {from, Mat3::Identity()});
  for (int i = 1; i <= ticks; i++) {
    const auto done = hand.advance(tool, from + (to - from) * i / ticks, Vec3::Zero(), Mode::cut,
                                   {}, {Material{}});
    if (!done) fail(done.error());
  }
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  std::string only;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0)
      json = true;
    else if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else if (std::strcmp(argv[i], "--only") == 0 && i + 1 < argc)
      only = argv[++i];
    else {
      std::fprintf(stderr, "bodies_bench: unknown option %s\n", argv[i]);
      return 1;
    }
  }
  std::string out;
  for (const int nodes : {256, 512}) {
    if (quick && nodes > 256) break;
    const double n = nodes;
    Lattice lattice;
    lattice.nodes = Index3::Constant(nodes);
    TriDexel model(lattice);
    model.fill_block({{8, 8, 8}, {n - 8, n - 8, n - 8}}, 0);
    // Its top is scraped all over.
    for (double y = 8; y < n; y += 10)
      stroke(model, BallTool{8}, {0, y, n - 12}, {n, y + 3, n - 14}, nodes / 4);
    const Snapshot scraped = model.snapshot();
    const int rounds = quick ? 3 : 40;
    const auto timed = [&](const char* what, const std::function<void()>& prepare,
                           const std::function<size_t()>& run, size_t expected) {
      if (std::string_view(what).find(only) == std::string_view::npos) return;
      std::vector<double> ms;
      for (int i = 0; i < rounds; i++) {
        model.restore(scraped);
        prepare();
        const double began = now_us();
        const size_t came = run();
        ms.push_back((now_us() - began) / 1000);
        if (came != expected) fail(std::string(what) + " gave other bodies than it should");
      }
      char text[300];
      std::snprintf(text, sizeof text,
                    json ? "{\"nodes\":%d,\"what\":\"%s\",\"p50_ms\":%.2f,\"p99_ms\":%.2f},\n "
                         : "%d^3, %s: p50 %.2f ms, p99 %.2f ms\n",
                    nodes, what, median(ms), percentile(ms, 0.99));
      out += text;
    };
    const auto nothing = [] {};
    const Vec3 point = Vec3::Constant(0.5 * n + 0.3);
    const Cutter plane{CutPlane{point, Vec3::UnitX()}};
    const Cutter tilted{CutPlane{point, Vec3(1, 0.4, 0.3).normalized()}};
    CutCurve curve;
    for (int i = 0; i <= 60; i++)
      curve.curve_mm.push_back({0.5 * n + 0.05 * n * std::sin(0.2 * i), n * i / 60, 0});
    const Cutter line{curve};
    curve.along = Vec3(0.3, 0.2, 1).normalized();
    const Cutter askew{curve};
    Cutter saw = tilted;
    saw.kerf_mm = 3;
    Cutter wire = line;
    wire.kerf_mm = 2;
    for (const auto& [name, cutter] : {std::pair{"split by a plane", plane},
                                       {"split by a tilted plane", tilted},
                                       {"split along a line of 60 places", line},
                                       {"split along that line, drawn askew", askew},
                                       {"split by a saw of 3 cells", saw},
                                       {"split by a wire of 2 cells along the line", wire}})
      for (const int threads : {1, 2}) {
        CutOff off;  // what a person keeps
        timed((std::string(name) + (threads == 2 ? ", two threads" : "")).c_str(),
              [&] { off = {}; },
              [&, &by = cutter] {
                off = cut_off(model, by, threads);
                return off.portions.size();
              },
              1);
      }
    model.restore(scraped);
    Bodies parted = Bodies::of(model);
    if (const auto done = apply(parted, {{}, BodyCut{tilted}}); !done) fail(done.error());
    const BodyAction join{{1, 2}, BodyJoin{}};
    timed(
        "two halves joined", nothing,
        [&] {
          Bodies bodies = parted;
          if (const auto done = apply(bodies, join); !done) fail(done.error());
          return bodies.all.size();
        },
        1);
    int threads = 1;
    const auto crumbs = [&] {
      CrumbResult result = take_crumbs(model, scraped, Crumbs::sort, nullptr, threads);
      return result.portions.size() + 10 * static_cast<size_t>(result.fallen);
    };
    const double top = n - 12;
    timed(
        "after a stroke over the top",
        [&] {
          stroke(model, BallTool{16}, {20, 0.5 * n, top - 6}, {n - 20, 0.55 * n, top - 6},
                 nodes / 2);
        },
        crumbs, 0);
    timed(
        "after a stroke of a tenth of that",
        [&] {
          stroke(model, BallTool{16}, {0.5 * n, 0.5 * n, top - 6}, {0.6 * n, 0.5 * n, top - 6},
                 nodes / 20);
        },
        crumbs, 0);
    // Through the whole height, past the corner.
    const Flat mill{4, 2 * n};
    timed(
        "after one that severs a corner",
        [&] {
          stroke(model, mill, {0, 40, 0}, {40, 0, 0}, 60);
        },
        crumbs, 10);
    for (const char* what :
         {"after one that severs half of it", "after one that severs half of it, two threads"}) {
      timed(
          what,
          [&] {
            stroke(model, mill, {0.5 * n, 0, 0}, {0.5 * n, n, 0}, nodes);
          },
          crumbs, 1);
      threads = 2;
    }
  }
  if (json && !out.empty()) out.erase(out.rfind(','));
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
