// SPDX-License-Identifier: MIT
// Measures the time to split and join bodies, and to search for severed pieces after a stroke. The
// body is a cube whose sides strokes have scraped. A plane, a hand-drawn line and a saw split it,
// and the two halves are joined again. A stroke severs nothing, a corner, or half of the cube.
// Splits and the half cube run on one thread and on two.
//
//   bodies_bench [--json] [--quick] [--only TEXT]     (only those with TEXT in their name)
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

struct Options {
  bool json = false, quick = false;
  std::string only;
};

// A cube of n^3 nodes with a completely scraped top, and its measurements.
class ScrapedCube {
 public:
  ScrapedCube(int nodes, const Options& options)
      : options_(options), nodes_(nodes), n_(nodes), model_(cube(nodes)) {
    model_.fill_block({{8, 8, 8}, {n_ - 8, n_ - 8, n_ - 8}}, 0);
    for (double y = 8; y < n_; y += 10)
      stroke(model_, BallTool{8}, {0, y, n_ - 12}, {n_, y + 3, n_ - 14}, nodes / 4);
    scraped_ = model_.snapshot();
    tilted_.shape = CutPlane{Vec3::Constant(0.5 * n_ + 0.3), Vec3(1, 0.4, 0.3).normalized()};
  }

  // Runs all measurements and returns the report.
  std::string run() {
    time_splits();
    time_join();
    time_severing();
    return std::move(out_);
  }

 private:
  static Lattice cube(int nodes) {
    Lattice lattice;
    lattice.nodes = Index3::Constant(nodes);
    return lattice;
  }

  // Times run() on the scraped cube after prepare(). run() must return `expected`.
  void timed(const char* what, const std::function<void()>& prepare,
             const std::function<size_t()>& run, size_t expected) {
    if (std::string_view(what).find(options_.only) == std::string_view::npos) return;
    const int rounds = options_.quick ? 3 : 40;
    std::vector<double> ms;
    for (int i = 0; i < rounds; i++) {
      model_.restore(scraped_);
      prepare();
      const double began = now_us();
      const size_t count = run();
      ms.push_back((now_us() - began) / 1000);
      if (count != expected) fail(std::string(what) + " gave other bodies than it should");
    }
    char text[300];
    std::snprintf(text, sizeof text,
                  options_.json
                      ? "{\"nodes\":%d,\"what\":\"%s\",\"p50_ms\":%.2f,\"p99_ms\":%.2f},\n "
                      : "%d^3, %s: p50 %.2f ms, p99 %.2f ms\n",
                  nodes_, what, median(ms), percentile(ms, 0.99));
    out_ += text;
  }

  void time_splits() {
    const Cutter plane{CutPlane{Vec3::Constant(0.5 * n_ + 0.3), Vec3::UnitX()}};
    CutCurve curve;
    for (int i = 0; i <= 60; i++)
      curve.curve_mm.push_back({0.5 * n_ + 0.05 * n_ * std::sin(0.2 * i), n_ * i / 60, 0});
    const Cutter line{curve};
    curve.along = Vec3(0.3, 0.2, 1).normalized();
    const Cutter oblique{curve};
    Cutter saw = tilted_;
    saw.kerf_mm = 3;
    Cutter wire = line;
    wire.kerf_mm = 2;
    for (const auto& [name, cutter] : {std::pair{"split by a plane", plane},
                                       {"split by a tilted plane", tilted_},
                                       {"split along a line of 60 places", line},
                                       {"split along that line, drawn askew", oblique},
                                       {"split by a saw of 3 cells", saw},
                                       {"split by a wire of 2 cells along the line", wire}})
      for (const int threads : {1, 2}) {
        CutOff off;  // the part that was cut off; prepare() frees it, so that this is not timed
        timed((std::string(name) + (threads == 2 ? ", two threads" : "")).c_str(),
              [&] { off = {}; },
              [&, &by = cutter] {
                off = cut_off(model_, by, threads);
                return off.portions.size();
              },
              1);
      }
  }

  void time_join() {
    model_.restore(scraped_);
    BodyList parted = BodyList::of(model_);
    if (const auto done = apply(parted, {{}, BodyCut{tilted_}}); !done) fail(done.error());
    const BodyAction join{{1, 2}, BodyJoin{}};
    timed(
        "two halves joined", [] {},
        [&] {
          BodyList bodies = parted;
          if (const auto done = apply(bodies, join); !done) fail(done.error());
          return bodies.all.size();
        },
        1);
  }

  // Times the search for severed pieces at the end of a stroke.
  void time_severing() {
    int threads = 1;
    const auto crumbs = [&] {
      CrumbResult result = take_crumbs(model_, scraped_, Crumbs::sort, nullptr, threads);
      return result.portions.size() + 10 * static_cast<size_t>(result.fallen);
    };
    const auto after = [&](const char* what, const Tool& tool, const Vec3& from, const Vec3& to,
                           int ticks, size_t expected) {
      timed(
          what, [&] { stroke(model_, tool, from, to, ticks); }, crumbs, expected);
    };
    const double z = n_ - 18;
    after("after a stroke over the top", BallTool{16}, {20, 0.5 * n_, z}, {n_ - 20, 0.55 * n_, z},
          nodes_ / 2, 0);
    after("after a stroke of a tenth of that", BallTool{16}, {0.5 * n_, 0.5 * n_, z},
          {0.6 * n_, 0.5 * n_, z}, nodes_ / 20, 0);
    // The mill cuts through the whole height.
    const Flat mill{4, 2 * n_};
    after("after one that severs a corner", mill, {0, 40, 0}, {40, 0, 0}, 60, 10);
    for (const char* what :
         {"after one that severs half of it", "after one that severs half of it, two threads"}) {
      after(what, mill, {0.5 * n_, 0, 0}, {0.5 * n_, n_, 0}, nodes_, 1);
      threads = 2;
    }
  }

  const Options& options_;
  const int nodes_;
  const double n_;
  TriDexel model_;
  Snapshot scraped_;
  Cutter tilted_;
  std::string out_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0)
      options.json = true;
    else if (std::strcmp(argv[i], "--quick") == 0)
      options.quick = true;
    else if (std::strcmp(argv[i], "--only") == 0 && i + 1 < argc)
      options.only = argv[++i];
    else {
      std::fprintf(stderr, "bodies_bench: unknown option %s\n", argv[i]);
      return 1;
    }
  }
  std::string out;
  for (const int nodes : {256, 512})
    if (!options.quick || nodes <= 256) out += ScrapedCube(nodes, options).run();
  if (options.json && !out.empty()) out.erase(out.rfind(','));
  std::printf(options.json ? "[%s]\n" : "%s", out.c_str());
}
