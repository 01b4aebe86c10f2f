// SPDX-License-Identifier: MIT
// Measures the conversion of a mesh to 512^3 and 1024^3 nodes (with --quick once, to 128^3) and
// back. Scan conversion and surface extraction alternate with OpenVDB's meshToVolume and
// volumeToMesh, on one thread. Extraction also runs on two threads.
//
//   import_bench [--json] [--quick] [MESH]     without MESH: a bumpy ball of 60 k triangles
#include <cstdio>
#include <string>

#include <kibori/edit/scan_convert.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/surface/surface.h>

#include "bench/workload.h"
#ifdef KIBORI_HAVE_OPENVDB
#include "bench/peers/openvdb_carve.h"
#endif

namespace {

using namespace kibori;
using namespace kibori_bench;

TriangleMesh bumpy_ball() {
  TriangleMesh mesh;
  constexpr int kRings = 173, kSides = 174;
  for (int i = 0; i <= kRings; i++)
    for (int j = 0; j < kSides; j++) {
      const double a = 3.14159265358979 * i / kRings, b = 2 * 3.14159265358979 * j / kSides;
      const double r = 1 + 0.1 * std::sin(7 * a) * std::cos(5 * b);
      mesh.vertices.emplace_back(r * std::sin(a) * std::cos(b), r * std::sin(a) * std::sin(b),
                                 -r * std::cos(a));
    }
  const auto at = [](int i, int j) { return static_cast<uint32_t>(i * kSides + j % kSides); };
  for (int i = 0; i < kRings; i++)
    for (int j = 0; j < kSides; j++) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
    }
  return mesh;
}

struct Times {
  std::vector<double> in, out, out_two;  // [ms]; two: on two threads
  std::vector<double> peer_in, peer_out;
  int64_t spans = 0;
  size_t triangles = 0, triangles_peer = 0;  // of the extracted surfaces
};

// Times the conversion of a mesh into dexels with n nodes along its longest side, and back. The
// mesh is 1 mm long.
Result<Times> time_mesh(const TriangleMesh& mesh, int n, int reps) {
  const Lattice lattice = make_lattice(mesh.bounds().size(), 1.0 / n, 0).value();
#ifdef KIBORI_HAVE_OPENVDB
  std::vector<float> xyz;
  std::vector<unsigned> faces;
  for (const Vec3& p : mesh.vertices)
    for (int i = 0; i < 3; i++) xyz.push_back(static_cast<float>(p[i]));
  for (const auto& t : mesh.triangles) faces.insert(faces.end(), t.begin(), t.end());
#endif
  Times times;
  for (int i = 0; i < reps; i++) {
    const double start = now_us();
    TriDexel model(lattice);
    const auto report = scan_convert(model, mesh, 0, {true, 1});
    times.in.push_back((now_us() - start) / 1000);
    if (!report) return Error{report.error()};
    times.spans = model.count().spans;
    const Snapshot snapshot = model.snapshot();
    for (const int threads : {1, 2, 1, 2, 1, 2}) {
      const double from = now_us();
      times.triangles = extract_surface(snapshot, threads).triangles.size();
      (threads == 1 ? times.out : times.out_two).push_back((now_us() - from) / 1000);
    }
#ifdef KIBORI_HAVE_OPENVDB
    if (i < 3) {
      const MeshTimes peer = openvdb_mesh_through_volume(xyz, faces, n);
      times.peer_in.push_back(peer.in_ms);
      times.peer_out.push_back(peer.out_ms);
      times.triangles_peer = peer.triangles_out;
    }
#endif
  }
  return times;
}

std::string report(const Times& times, int n, size_t triangles, bool json, bool first) {
  const double k = median(times.in), p = times.peer_in.empty() ? 0 : median(times.peer_in);
  // Million triangles per second.
  const auto speed = [](size_t count, const std::vector<double>& ms) {
    return static_cast<double>(count) / median(ms) / 1000;
  };
  const double s1 = speed(times.triangles, times.out), s2 = speed(times.triangles, times.out_two),
               // For OpenVDB an open mesh is hollow, so there is no surface to extract.
      sp = times.triangles_peer < times.triangles / 2 ? 0
                                                      : speed(times.triangles_peer, times.peer_out);
  char text[512];
  std::snprintf(text, sizeof text,
                json ? "%s{\"nodes\":%d,\"triangles\":%zu,\"kibori_ms\":%.1f,\"openvdb_ms\":%.1f,"
                       "\"ratio\":%.2f,"
                       "\"spans\":%lld,\"surface_triangles\":%zu,\"surface_mtriangles_s\":%.2f,"
                       "\"surface_two_threads_"
                       "mtriangles_s\":%.2f,"
                       "\"openvdb_surface_mtriangles_s\":%.2f,\"surface_ratio\":%.2f}"
                     : "%s%d^3, %zu triangles: kibori %.1f ms, OpenVDB meshToVolume %.1f ms, "
                       "ratio %.1f, %lld spans\n"
                       "        surface of %zu triangles: %.2f M/s, on two threads %.2f; OpenVDB "
                       "volumeToMesh %.2f, "
                       "ratio %.2f\n",
                json && !first ? ",\n " : "", n, triangles, k, p, p / k,
                static_cast<long long>(times.spans), times.triangles, s1, s2, sp,
                sp > 0 ? s1 / sp : 0);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  std::string path;
  for (int i = 1; i < argc; i++) {
    const std::string word = argv[i];
    if (word == "--json")
      json = true;
    else if (word == "--quick")
      quick = true;
    else
      path = word;
  }
  const auto fail = [](const std::string& why) {
    std::fprintf(stderr, "import_bench: %s\n", why.c_str());
    return 2;
  };
  Result<TriangleMesh> read = path.empty() ? Result<TriangleMesh>(bumpy_ball()) : read_mesh(path);
  if (!read) return fail(read.error());
  TriangleMesh mesh = std::move(read).value();
  const Box box = mesh.bounds();
  const double longest = box.size().maxCoeff();
  for (Vec3& p : mesh.vertices) p = (p - box.min) / longest;

  std::string out;
  for (const int n : quick ? std::vector<int>{128} : std::vector<int>{512, 1024}) {
    const Result<Times> times = time_mesh(mesh, n, quick ? 1 : 5);
    if (!times) return fail(times.error());
    out += report(times.value(), n, mesh.triangles.size(), json, out.empty());
  }
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
