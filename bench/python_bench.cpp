// SPDX-License-Identifier: MIT
// The C++ reference of bench/python_loop.py: a ball of 10 cells on a spiral. Prints the time per
// cut [us] and the hash. Usage: python_bench CUTS
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <kibori/edit/grain.h>
#include <kibori/haptics/materials.h>
#include <kibori/motion/direct_tool.h>

using namespace kibori;

int main(int count, char** arguments) {
  const int cuts = count > 1 ? std::atoi(arguments[1]) : 100000;
  const Vec3 size(80, 50, 30);
  TriDexel model(make_lattice(size, 0.5, 8).value());
  model.fill_block({Vec3::Zero(), size}, 0);
  model.reserve(1024);
  const std::vector<Material> materials{known_materials().front()};
  const std::shared_ptr<const Grain> grain = Grain::of(model.lattice(), materials);
  std::vector<Vec3> path;
  for (int i = 0; i <= cuts; i++) {
    const double share = static_cast<double>(i) / cuts, t = 40 * M_PI * share;
    path.emplace_back(40 + 30 * std::cos(t), 25 + 20 * std::sin(t), 28 - 2 * share);
  }
  DirectTool tool(model, {path.front(), Mat3::Identity()});
  tool.set_grain(grain.get());
  Vec3 sum = Vec3::Zero();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 1; i <= cuts; i++) {
    const Result<ToolTick> tick =
        tool.advance(BallTool{5}, path[static_cast<size_t>(i)], Vec3::Zero(), Mode::cut,
                     {ForceModel::energy}, materials);
    sum += tick.value().wrench.force;
  }
  const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - start;
  std::printf("%.6f %" PRIu64 " %.6g\n", took.count() / cuts, model.content_hash(), sum.norm());
}
