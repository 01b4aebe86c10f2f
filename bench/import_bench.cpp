// SPDX-License-Identifier: MIT
// A mesh into 512^3 and 1024^3 (128^3, once, when quick) and out again: scan conversion and surface
// extraction against OpenVDB's meshToVolume and volumeToMesh, one thread, in turn; extraction also
// on two.
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
  TriangleMesh mesh;
  if (path.empty()) {
    mesh = bumpy_ball();
  } else {
    Result<TriangleMesh> read = read_mesh(path);
    if (!read) return std::fprintf(stderr, "import_bench: %s\n", read.error().c_str()), 2;
    mesh = std::move(read).value();
  }
  const Box box = mesh.bounds();
  const double longest = box.size().maxCoeff();
  for (Vec3& p : mesh.vertices) p = (p - box.min) / longest;
  std::vector<float> xyz;
  std::vector<unsigned> faces;
  for (const Vec3& p : mesh.vertices)
    for (int i = 0; i < 3; i++) xyz.push_back(static_cast<float>(p[i]));
  for (const auto& t : mesh.triangles) faces.insert(faces.end(), t.begin(), t.end());

  std::string out;
  const int reps = quick ? 1 : 5;
  for (const int n : quick ? std::vector<int>{128} : std::vector<int>{512, 1024}) {
    const Lattice lattice = make_lattice(box.size() / longest, 1.0 / n, 0).value();
    std::vector<double> own, peer, out_own, out_two, out_peer;  // ms
    int64_t spans = 0;
    size_t triangles = 0, triangles_peer = 0;
    for (int i = 0; i < reps; i++) {
      const double start = now_us();
      TriDexel model(lattice);
      const auto report = scan_convert(model, mesh, 0, {true, 1});
      own.push_back((now_us() - start) / 1000);
      if (!report) return std::fprintf(stderr, "import_bench: %s\n", report.error().c_str()), 2;
      spans = model.count().spans;
      const Snapshot snapshot = model.snapshot();
      for (const int threads : {1, 2, 1, 2, 1, 2}) {
        const double from = now_us();
        triangles = extract_surface(snapshot, threads).triangles.size();
        (threads == 1 ? out_own : out_two).push_back((now_us() - from) / 1000);
      }
#ifdef KIBORI_HAVE_OPENVDB
      if (i < 3) {
        const MeshTimes times = openvdb_mesh_through_volume(xyz, faces, n);
        peer.push_back(times.in_ms);
        out_peer.push_back(times.out_ms);
        triangles_peer = times.triangles_out;
      }
#endif
    }
    const double k = median(own), p = peer.empty() ? 0 : median(peer);
    // Millions of triangles a second.
    const double s1 = static_cast<double>(triangles) / median(out_own) / 1000,
                 s2 = static_cast<double>(triangles) / median(out_two) / 1000,
                 // An open mesh is hollow to OpenVDB, and there is no surface to extract.
        sp = triangles_peer < triangles / 2
                 ? 0
                 : static_cast<double>(triangles_peer) / median(out_peer) / 1000;
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
                  json && !out.empty() ? ",\n " : "", n, mesh.triangles.size(), k, p, p / k,
                  static_cast<long long>(spans), triangles, s1, s2, sp, sp > 0 ? s1 / sp : 0);
    out += text;
  }
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
