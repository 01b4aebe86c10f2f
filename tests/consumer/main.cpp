// SPDX-License-Identifier: MIT
// What a program that uses an installed Kibori looks like: carve a block with a ball and print the force.
#include <cstdio>

#include <kibori/motion/stroke.h>

int main() {
  using namespace kibori;
  Result<Lattice> lattice = make_lattice(Vec3(30, 20, 10), 0.25, 1);
  if (!lattice) return std::fprintf(stderr, "%s\n", lattice.error().c_str()), 2;
  TriDexel model(lattice.value());
  model.fill_block({Vec3::Zero(), Vec3(30, 20, 10)}, 0);
  Stroke stroke(model, Pose{Vec3(-5, 10, 7), Mat3::Identity()});
  double removed = 0, force = 0;
  for (int i = 1; i <= 100; i++) {
    const auto tick = stroke.advance(BallTool{4}, Vec3(-5 + 0.2 * i, 10, 7), Vec3::Zero(), Mode::cut,
                                     {ForceModel::energy, 6}, {Material{}});
    if (!tick) return std::fprintf(stderr, "%s\n", tick.error().c_str()), 2;
    removed += tick.value().removed_mm3;
    force = tick.value().wrench.force.norm();
  }
  std::printf("removed %.3f mm3, force %.3f N\n", removed, force);
  return removed > 0 && force > 0 ? 0 : 1;
}
