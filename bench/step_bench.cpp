// SPDX-License-Identifier: MIT
// Measures one step of a ball that scrapes a block. Kibori computes a cut in three directions,
// normals, removed volume and moments, and the wrench. It takes turns with OpenVDB's level-set and
// bit-mask stamps in one process, on one thread.
//
//   step_bench [--json] [--quick] [--reps N] [--steps N] [--nodes N] [--radius R]
//              [--only kibori] [--memory | --instructions]
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <kibori/base/percent.h>
#include <kibori/motion/direct_tool.h>

#include "bench/instruction_count.h"
#include "bench/workload.h"
#ifdef KIBORI_HAVE_OPENVDB
#include "bench/peers/openvdb_carve.h"
#endif

namespace {

using namespace kibori;
using namespace kibori_bench;

struct Options {
  int nodes = 0, reps = 0, steps = 0;  // 0: the default
  float radius = 0;                    // 0: all three
  bool json = false, quick = false, kibori_only = false, memory = false, instructions = false;
};

Vec3 centre(const Point& p) {  // voxel i of the workload is the lattice node at i + 1/2
  return {static_cast<double>(p.x) + 0.5, static_cast<double>(p.y) + 0.5,
          static_cast<double>(p.z) + 0.5};
}

std::unique_ptr<TriDexel> block(int nodes) {
  Lattice lattice;
  lattice.nodes = Index3(nodes, nodes, nodes);
  auto model = std::make_unique<TriDexel>(lattice);
  model->fill_block({Vec3::Zero(), Vec3::Constant(nodes)}, 0);
  model->reserve(6000);
  return model;
}

// Times DirectTool::advance, as the product calls it in force model `energy`.
StepTimes carve_steps(int nodes, const std::vector<Point>& path, float radius, int jump_every,
                      int snapshot_every) {
  auto model = block(nodes);
  const std::vector<Material> materials{Material{}};
  const Vec3 up = Vec3::UnitZ() * static_cast<double>(radius);
  const Tool ball = BallTool{static_cast<double>(radius)};
  DirectTool stroke(*model, Pose{centre(path[0]) - up, Mat3::Identity()});
  Snapshot kept;
  StepTimes result;
  result.us.reserve(path.size());
  int64_t points = 0;
  double force = 0;
  for (size_t i = 0; i < path.size(); i++) {
    if (jump_every > 0 && i > 0 && i % static_cast<size_t>(jump_every) == 0)
      stroke.place(Pose{centre(path[i]) - up, Mat3::Identity()});
    const double start = now_us();
    if (snapshot_every > 0 && i % static_cast<size_t>(snapshot_every) == 0)
      kept = model->snapshot();
    const auto tick = stroke.advance(ball, centre(path[i]) - up, Vec3::Zero(), Mode::cut,
                                     {ForceModel::energy, 6}, materials);
    result.us.push_back(now_us() - start);
    points += tick.value().points;
    force += tick.value().wrench.force.squaredNorm();
  }
  result.removed = static_cast<double>(points) + (force < 0 ? 1 : 0);
  result.bytes = static_cast<double>(model->count().bytes);
  return result;
}

// Times cuts of the z field alone.
StepTimes carve_single_direction(int nodes, const std::vector<Point>& path, float radius) {
  auto model = block(nodes);
  StepTimes result;
  Vec3 last = centre(path[0]);
  for (size_t i = 0; i < path.size(); i++) {
    const Vec3 to = centre(path[i]);
    const double start = now_us();
    Removed removed;
    Motion motion;
    motion.reference = {to};
    cut_field(
        model->field(Axis::z),
        SweptBall(LatticePoint{last}, LatticeVector{to - last}, static_cast<double>(radius), i > 0),
        motion, removed);
    result.us.push_back(now_us() - start);
    result.removed += static_cast<double>(removed.points());
    last = to;
  }
  return result;
}

struct Series {
  std::vector<double> medians, p999;
  StepTimes last;
  void add(StepTimes times) {
    medians.push_back(median(times.us));
    p999.push_back(percentile(times.us, 0.999));
    last = std::move(times);
  }
  double us() const { return median(medians); }
  double us_p999() const { return median(p999); }
};

// The same path for every lattice, so that only the model's size differs.
std::vector<Point> scrape(const Options& o, float radius, int jump_every) {
  const int nodes = std::min(o.nodes, 512);
  auto path = scrape_path(nodes, radius, o.steps, jump_every);
  for (Point& p : path) p.z += static_cast<float>(o.nodes - nodes);
  return path;
}

void step(const Options& o) {
  if (!o.json)
    std::printf(
        "%d^3 lattice, %d steps, median of %d runs, us a step\n%-6s %8s %8s %9s %8s %8s %7s %7s "
        "%7s %9s %8s "
        "%8s %10s\n",
        o.nodes, o.steps, o.reps, "R", "kibori", "p99.9", "levelset", "bitmask", "csg", "x level",
        "x bits", "x csg", "jumps", "z only", "tri/z", "removed");
  std::string json;
  for (const float radius : {16.f, 32.f, 64.f}) {
    if (o.radius > 0 && radius != o.radius) continue;
    const auto path = scrape(o, radius, 0), jumps = scrape(o, radius, 50);
    Series own, jumping, single, level, bits, csg;
    for (int i = 0; i < o.reps; i++) {
      own.add(carve_steps(o.nodes, path, radius, 0, 0));
#ifdef KIBORI_HAVE_OPENVDB
      if (!o.kibori_only) {
        level.add(openvdb_levelset_stamp(o.nodes, path, radius));
        bits.add(openvdb_bitmask_stamp(o.nodes, path, radius));
      }
#endif
      jumping.add(carve_steps(o.nodes, jumps, radius, 50, 16));
      single.add(carve_single_direction(o.nodes, path, radius));
    }
#ifdef KIBORI_HAVE_OPENVDB
    // csgDifference takes milliseconds per step, so run at most 50 steps.
    if (!o.kibori_only)
      csg.add(openvdb_csg_difference(o.nodes, {path.begin(), path.begin() + std::min(o.steps, 50)},
                                     radius));
#endif
    const bool peers = !level.medians.empty();
    const double l = peers ? level.us() : 0, b = peers ? bits.us() : 0, c = peers ? csg.us() : 0;
    const double off = peers ? own.last.removed / bits.last.removed - 1 : 0;
    if (o.json) {
      char text[512];
      std::snprintf(text, sizeof text,
                    "%s{\"radius_cells\":%g,\"kibori_us\":%.3f,\"kibori_p999_us\":%.3f,\"levelset_"
                    "us\":%.3f,\"bitmask_"
                    "us\":%.3f,\"csg_difference_us\":%.1f,"
                    "\"ratio\":%.3f,\"ratio_bitmask\":%.3f,\"ratio_csg_difference\":%.0f,\"jumps_"
                    "snapshots_us\":%.3f,"
                    "\"single_direction_us\":%.3f,"
                    "\"removed_nodes\":%.0f,\"removed_difference\":%.6f}",
                    json.empty() ? "" : ",\n ", static_cast<double>(radius), own.us(),
                    own.us_p999(), l, b, c, l / own.us(), b / own.us(), c / own.us(), jumping.us(),
                    single.us(), own.last.removed, off);
      json += text;
    } else {
      std::printf(
          "%-6g %8.2f %8.1f %9.2f %8.2f %8.0f %6.2fx %6.2fx %6.0fx %9.2f %8.2f %7.2fx %10s\n",
          static_cast<double>(radius), own.us(), own.us_p999(), l, b, c, l / own.us(), b / own.us(),
          c / own.us(), jumping.us(), single.us(), own.us() / single.us(),
          peers ? percent(off).c_str() : "-");
    }
    std::fflush(stdout);
  }
  if (o.json) std::printf("[%s]\n", json.c_str());
}

void memory(const Options& o) {
  const auto path = scrape_path(o.nodes, 16, o.steps);
  const double plain = static_cast<double>(block(o.nodes)->count().bytes);
  const double carved = carve_steps(o.nodes, path, 16, 0, 0).bytes;
  double level = 0;
#ifdef KIBORI_HAVE_OPENVDB
  if (!o.kibori_only) level = openvdb_levelset_stamp(o.nodes, path, 16).bytes;
#endif
  if (o.json)
    std::printf(
        "{\"plain_block_bytes\":%.0f,\"after_scrape_bytes\":%.0f,\"levelset_bytes\":%.0f,\"ratio\":"
        "%.1f}\n",
        plain, carved, level, level / carved);
  else
    std::printf(
        "%d^3 block: plain %.3f MB, after the scrape %.3f MB; OpenVDB level set %.1f MB, ratio "
        "%.1f\n",
        o.nodes, plain / 1e6, carved / 1e6, level / 1e6, level / carved);
}

void instructions(const Options& o) {
  const size_t from = o.quick ? 50 : 700, steps = o.quick ? 1 : 8;
  std::string json;
  for (const float radius : {16.f, 32.f, 64.f}) {
    const auto path = scrape_path(o.nodes, radius, static_cast<int>(from + steps));
    auto model = block(o.nodes);
    const std::vector<Material> materials{Material{}};
    const Vec3 up = Vec3::UnitZ() * static_cast<double>(radius);
    const Tool ball = BallTool{static_cast<double>(radius)};
    DirectTool stroke(*model, Pose{centre(path[0]) - up, Mat3::Identity()});
    const auto step = [&](size_t i) {
      const auto tick = stroke.advance(ball, centre(path[i]) - up, Vec3::Zero(), Mode::cut,
                                       {ForceModel::energy, 6}, materials);
      if (!tick.ok()) std::abort();
    };
    for (size_t i = 0; i < from; i++) step(i);
    const int64_t count = count_instructions([&] {
      for (size_t i = from; i < from + steps; i++) step(i);
    });
    if (count < 0) {
      std::puts(o.json ? "[]"
                       : "skipped: instructions can't be counted where no process may be traced");
      return;
    }
    const double each = static_cast<double>(count) / static_cast<double>(steps);
    char text[160];
    std::snprintf(text, sizeof text,
                  o.json ? "%s{\"radius_cells\":%g,\"instructions\":%.0f}"
                         : "%sR = %-3g %8.0f instructions a step\n",
                  o.json && !json.empty() ? ",\n " : "", static_cast<double>(radius), each);
    json += text;
  }
  std::printf(o.json ? "[%s]\n" : "%s", json.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i++) {
    const std::string word = argv[i];
    const bool more = i + 1 < argc;
    if (word == "--json")
      options.json = true;
    else if (word == "--quick")
      options.quick = true;
    else if (word == "--memory")
      options.memory = true;
    else if (word == "--instructions")
      options.instructions = true;
    else if (word == "--only" && more && std::strcmp(argv[i + 1], "kibori") == 0)
      options.kibori_only = true, i++;
    else if (word == "--reps" && more)
      options.reps = std::max(1, std::atoi(argv[++i]));
    else if (word == "--radius" && more)
      options.radius = static_cast<float>(std::atof(argv[++i]));
    else if (word == "--nodes" && more)
      options.nodes = std::atoi(argv[++i]);
    else if (word == "--steps" && more)
      options.steps = std::max(1, std::atoi(argv[++i]));
    else
      return std::fprintf(stderr, "step_bench: unknown option %s\n", argv[i]), 2;
  }
  const auto unless_given = [&](int& number, int quick, int usual) {
    if (number == 0) number = options.quick ? quick : usual;
  };
  unless_given(options.nodes, 256, options.memory ? 1024 : 512);
  unless_given(options.reps, 1, 5);
  unless_given(options.steps, 100, 2000);
  if (options.memory)
    memory(options);
  else if (options.instructions)
    instructions(options);
  else
    step(options);
}
