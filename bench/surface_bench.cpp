// SPDX-License-Identifier: MIT
// Measures three uses of the surface: rebuilding its chunks after one step of a ball that scrapes a
// block, writing STL, and converting a mesh through dexels to a file.
//
//   surface_bench [--json] [--quick] [MESH]     without MESH: no mesh through dexels
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include <unistd.h>

#include <kibori/report/convert.h>
#include <kibori/formats/surface_file.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/surface/surface.h>

#include "bench/workload.h"
#ifdef KIBORI_HAVE_OPENVDB
#include "bench/peers/openvdb_carve.h"
#endif

namespace {

using namespace kibori;
using namespace kibori_bench;

struct Remesh {
  double ms = 0, chunks = 0, triangles = 0;  // medians of a step
};

Remesh remesh(int nodes, float radius, int steps, int from) {
  Lattice lattice;
  lattice.nodes = Index3(nodes, nodes, nodes);
  TriDexel model(lattice);
  model.fill_block({Vec3::Zero(), Vec3::Constant(nodes)}, 0);
  const auto path = scrape_path(nodes, radius, from + steps);
  const auto centre = [&](size_t i) {
    return Vec3(static_cast<double>(path[i].x) + 0.5, static_cast<double>(path[i].y) + 0.5,
                static_cast<double>(path[i].z) + 0.5);
  };
  const std::vector<Material> materials{Material{}};
  const Vec3 up = Vec3::UnitZ() * static_cast<double>(radius);
  const Tool ball = BallTool{static_cast<double>(radius)};
  DirectTool stroke(model, Pose{centre(0) - up, Mat3::Identity()});
  const auto step = [&](size_t i) {
    const auto tick = stroke.advance(ball, centre(i) - up, Vec3::Zero(), Mode::cut,
                                     {ForceModel::energy, 6}, materials);
    if (!tick.ok()) std::abort();
  };
  for (size_t i = 0; i < static_cast<size_t>(from); i++) step(i);
  LiveSurface surface(model.snapshot());
  std::vector<double> ms, chunks, triangles;
  for (size_t i = static_cast<size_t>(from); i < path.size(); i++) {
    step(i);
    const double start = now_us();
    const std::vector<Index3>& changed = surface.update(model.snapshot());
    ms.push_back((now_us() - start) / 1000);
    chunks.push_back(static_cast<double>(changed.size()));
    double count = 0;
    for (const Index3& c : changed) count += static_cast<double>(surface.chunk(c).triangles.size());
    triangles.push_back(count);
  }
  return {median(ms), median(chunks), median(triangles)};
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  std::string mesh;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0)
      json = true;
    else if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else
      mesh = argv[i];
  }
  const int nodes = quick ? 128 : 512, before = quick ? 20 : 700, steps = quick ? 20 : 400,
            reps = quick ? 1 : 5;
  std::string out;
  char text[400];
  for (const float radius : {16.f, 32.f}) {
    const Remesh own = remesh(nodes, radius, steps, before);
    double peer = 0, peer_triangles = 0;
#ifdef KIBORI_HAVE_OPENVDB
    const StepTimes times = openvdb_local_remesh(nodes, scrape_path(nodes, radius, before + 20),
                                                 radius, before, &peer_triangles);
    peer = median(times.us) / 1000;
#endif
    std::snprintf(
        text, sizeof text,
        json ? "{\"radius_cells\":%g,\"remesh_ms\":%.3f,\"chunks\":%.0f,\"triangles\":%.0f,"
               "\"openvdb_ms\":%.3f,"
               "\"openvdb_triangles\":%.0f,\"ratio\":%.2f},\n "
             : "R = %g: remesh after a step %.3f ms (%.0f chunks, %.0f triangles); OpenVDB around "
               "the ball %.3f "
               "ms (%.0f triangles), ratio %.2f\n",
        static_cast<double>(radius), own.ms, own.chunks, own.triangles, peer, peer_triangles,
        peer / own.ms);
    out += text;
  }
  // Times the writing alone: a sphere's surface, into memory (/dev/shm) if possible.
  Lattice lattice;
  const double middle = quick ? 50 : 200;
  lattice.nodes = Index3::Constant(static_cast<int>(2 * middle));
  TriDexel model(lattice);
  Removed removed;
  deposit(model, SweptBall(LatticePoint{Vec3::Constant(middle)}, LatticeVector(), middle - 10), 0,
          {}, removed);
  const Surface ball = extract_surface(model.snapshot());
  const std::filesystem::path folder =
      access("/dev/shm", W_OK) == 0 ? "/dev/shm" : std::filesystem::temp_directory_path();
  const auto file = folder / ("kibori-bench-" + std::to_string(getpid()) + ".stl");
  std::vector<double> rates;
  for (int i = 0; i < reps; i++) {
    const double start = now_us();
    if (!write_surface(file, [&](const SurfaceSink& sink) { send_surface(ball, sink); }, {}).ok())
      return 2;
    rates.push_back(static_cast<double>(std::filesystem::file_size(file)) / (now_us() - start));
  }
  std::vector<double> through;
  if (!mesh.empty()) {
    const Result<Converted> coarse = into_dexels(mesh, {});  // 256 along the longest side
    if (!coarse) return std::fprintf(stderr, "surface_bench: %s\n", coarse.error().c_str()), 2;
    ConvertOptions fine;
    fine.pitch_mm = coarse.value().pitch_mm / 2;
    for (int i = 0; i < reps; i++) {
      const double from = now_us();
      const Result<Converted> made = into_dexels(mesh, fine);
      if (!made || !write_model(file, made.value().model->snapshot(), {}, 0, 1).ok()) return 2;
      through.push_back((now_us() - from) / 1000);
    }
  }
  std::filesystem::remove(file);
  std::snprintf(text, sizeof text, json ? "{\"stl_mb_s\":%.0f" : "STL to memory %.0f MB/s",
                median(rates));
  out += text;
  if (!through.empty()) {
    std::snprintf(text, sizeof text,
                  json ? ",\"convert_512_ms\":%.0f" : "; mesh to 512^3 to STL %.0f ms",
                  median(through));
    out += text;
  }
  out += json ? "}" : "\n";
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
