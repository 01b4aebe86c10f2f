// SPDX-License-Identifier: MIT
// A batch of cuts against the same cuts one by one: the model to the bit, the sums to the bit for
// any number of threads and any division into batches, and to rounding against cut().
#include <cmath>
#include <deque>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/batch.h>
#include <kibori/solid/tool.h>

#include "tests/support.h"

namespace kibori::mill_batch_tests {
namespace {

using test::Random;

std::unique_ptr<TriDexel> block() {
  Lattice lattice;
  lattice.nodes = Index3(75, 50, 33);
  lattice.origin_mm = Vec3(-3, 2, 1);
  lattice.pitch_mm = 0.5;
  auto model = std::make_unique<TriDexel>(lattice);
  model->fill_block(lattice.to_mm(lattice.whole()), 0);
  return model;
}

struct Sweep {
  Tool tool;
  Pose start;
  Vec3 travel;
  bool writes;
};

// Paths of several tools: along the axes on planes of nodes, and oblique.
std::vector<Sweep> random_sweeps(Random& random, int count) {
  std::vector<Sweep> sweeps;
  Lollipop ball_end;
  ball_end.radius = ball_end.neck = ball_end.shank = 2;
  ball_end.reach = ball_end.length = 20;
  const Tool tools[] = {Flat{2.25, 20}, ball_end, Bull{2.5, 1, 20}, Cone{60, 3, 20}, BallTool{2}};
  Vec3 at(5, 10, 14);
  for (int i = 0; i < count; i++) {
    Sweep s;
    s.tool = tools[random.integer(0, 4)];
    s.start.tip = at;
    Vec3 to = at + random.in_box(-6, 6);
    // Half of the ends are on planes of nodes, so that walls and floors are tied.
    if (random.integer(0, 1))
      for (int k = 0; k < 3; k++) to[k] = std::floor(to[k]) + 0.25;
    if (random.integer(0, 2) == 0) to[random.integer(0, 2)] = at[random.integer(0, 2)];
    to = to.cwiseMax(Vec3(-5, 0, 6)).cwiseMin(Vec3(36, 28, 18));
    s.travel = to - at;
    s.writes = random.integer(0, 4) != 0;
    sweeps.push_back(s);
    at = to;
  }
  return sweeps;
}

struct Prepared {
  std::deque<SweptTool> solids;
  std::vector<BatchCut> cuts;
};

Prepared prepare(const std::vector<Sweep>& sweeps, const Lattice& lattice) {
  Prepared all;
  for (const Sweep& s : sweeps) {
    all.solids.emplace_back(s.tool, s.start, s.travel, lattice);
    BatchCut cut;
    cut.solid = &all.solids.back().solid();
    cut.reference = lattice.to_lattice(s.start.tip + s.travel);
    cut.shift = lattice.vector_to_lattice(s.travel);
    cut.writes = s.writes;
    cut.chip = true;
    all.cuts.push_back(cut);
  }
  return all;
}

std::vector<CutSums> run(TriDexel& model, const std::vector<BatchCut>& cuts, size_t at_once,
                         int threads) {
  std::vector<CutSums> sums;
  for (size_t i = 0; i < cuts.size(); i += at_once) {
    const auto part =
        cut_batch(model, std::span(cuts).subspan(i, std::min(at_once, cuts.size() - i)),
                  {threads, BatchFields::all});
    sums.insert(sums.end(), part.begin(), part.end());
  }
  return sums;
}

TEST(Batch, EqualsOneByOne) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_ROUNDS", 4); round++) {
    const auto sweeps = random_sweeps(random, 150);
    auto model = block();
    const Prepared all = prepare(sweeps, model->lattice());
    // The oracle: cut and contact.
    std::vector<Removed> oracle(sweeps.size());
    for (size_t i = 0; i < sweeps.size(); i++) {
      EditOptions options;
      options.motion.reference = all.cuts[i].reference;
      if (sweeps[i].writes)
        cut(*model, *all.cuts[i].solid, options, oracle[i]);
      else
        contact(*model, *all.cuts[i].solid, options, oracle[i]);
    }
    std::vector<CutSums> first;
    for (const size_t at_once : {size_t{150}, size_t{1}, size_t{37}})
      for (const int threads : {1, 2, 8}) {
        auto own = block();
        const auto sums = run(*own, all.cuts, at_once, threads);
        ASSERT_EQ(own->content_hash(), model->content_hash()) << at_once << " " << threads;
        if (first.empty()) first = sums;
        for (size_t i = 0; i < sums.size(); i++) {
          ASSERT_EQ(sums[i].points, first[i].points) << i << " " << at_once << " " << threads;
          ASSERT_EQ(sums[i].volume, first[i].volume) << i << " " << at_once << " " << threads;
          ASSERT_EQ(sums[i].moment, first[i].moment) << i << " " << at_once << " " << threads;
          ASSERT_EQ(sums[i].second, first[i].second) << i << " " << at_once << " " << threads;
          ASSERT_EQ(sums[i].points, oracle[i].points()) << i;
          ASSERT_NEAR(sums[i].volume, oracle[i].volume(), 1e-6 * (1 + std::abs(oracle[i].volume())))
              << i;
        }
      }
  }
}

}  // namespace
}  // namespace kibori::mill_batch_tests
