// SPDX-License-Identifier: MIT
// Measures one step of every tool. Each tool is as wide as a ball of R = 32 cells. It scrapes the
// top of a block of 512^3 nodes. The depth is a quarter of the radius, and a step is one cell. The
// force model is `energy`. The stock is first a material without grain, and then oak, whose grain
// and rings affect the force. Then the tool also turns in each step, in the first material.
//
//   tools_bench [--json] [--quick] [SHAPE]
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <kibori/scene/stamp.h>
#include <kibori/haptics/materials.h>
#include <kibori/motion/direct_tool.h>

#include "bench/workload.h"
#include "tests/every_tool.h"

using namespace kibori;
using namespace kibori_bench;

namespace {

constexpr int kNodes = 512, kRadius = 32;
constexpr double kTurn = 0.001;  // about the vertical axis [rad]: 57 degrees per second

Tool tool_of(size_t shape) {
  const double length = 100;
  if (shape == test::kMeshShape) {
    // Letters as wide as the other tools. Without the font, returns an invalid tool, which main()
    // skips.
    const Result<Tool> stamp = text_stamp({"KIBORI", "DejaVu Sans", 0.45 * kRadius, length, 0}, 1);
    return stamp ? stamp.value() : MeshTool{};
  }
  return test::usual_tool(shape, {kRadius, length});
}

// `turn`: rotation vector of each step [rad].
std::vector<double> steps_of(const Tool& tool, const Material& material, int steps,
                             const Vec3& turn = Vec3::Zero()) {
  Lattice lattice;
  lattice.nodes = Index3(kNodes, kNodes, kNodes);
  TriDexel model(lattice);
  model.fill_block({Vec3::Zero(), Vec3::Constant(kNodes)}, 0);
  model.reserve(6000);
  const std::vector<Material> materials{material};
  const std::shared_ptr<const Grain> grain = Grain::of(lattice, materials);
  const std::vector<Point> path = scrape_path(kNodes, kRadius, steps);
  const auto tip = [&](const Point& p) {
    return Vec3(p.x + 0.5, p.y + 0.5, p.z + 0.5 - 0.25 * kRadius);
  };
  DirectTool stroke(model, Pose{tip(path[0]), Mat3::Identity()});
  stroke.set_grain(grain.get());
  std::vector<double> us;
  us.reserve(path.size());
  for (const Point& p : path) {
    const double start = now_us();
    if (!stroke.advance(tool, tip(p), turn, Mode::cut, {ForceModel::energy, 6}, materials))
      std::abort();
    us.push_back(now_us() - start);
  }
  return us;
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
    else if (const auto tool = default_tool(argv[i]))
      only = argv[i];
    else
      return std::fprintf(stderr, "tools_bench: unknown option %s\n", argv[i]), 2;
  }
  const int steps = quick ? 200 : 2000;
  Material oak;
  for (const Material& known : known_materials())
    if (known.name == "oak") oak = known;
  nlohmann::ordered_json all;
  if (!json)
    std::printf("us a step, R = 32 cells in 512^3\n%-10s %9s %8s %8s %8s %8s %8s %6s\n", "",
                "plain p50", "p99", "oak p50", "p99", "turn p50", "p99", "ratio");
  for (size_t i = 0; i < kToolShapes.size(); i++) {
    const char* const shape = kToolShapes[i];
    if (!only.empty() && only != shape) continue;
    const Tool tool = tool_of(i);
    // Skip the half-space, which is infinite.
    if (!check_tool(tool) || !std::isfinite(reach_mm(tool))) continue;
    const std::vector<double> plain = steps_of(tool, Material{}, steps),
                              step_times = steps_of(tool, oak, steps),
                              turning = steps_of(tool, Material{}, steps, Vec3(0, 0, kTurn));
    all[shape] = {
        {"plain_p50_us", median(plain)},     {"plain_p99_us", percentile(plain, 0.99)},
        {"oak_p50_us", median(step_times)},  {"oak_p99_us", percentile(step_times, 0.99)},
        {"turning_p50_us", median(turning)}, {"turning_p99_us", percentile(turning, 0.99)}};
    if (!json)
      std::printf("%-10s %9.1f %8.1f %8.1f %8.1f %8.1f %8.1f %6.1f\n", shape, median(plain),
                  percentile(plain, 0.99), median(step_times), percentile(step_times, 0.99),
                  median(turning), percentile(turning, 0.99), median(turning) / median(plain));
  }
  if (json) std::printf("%s\n", all.dump(1).c_str());
}
