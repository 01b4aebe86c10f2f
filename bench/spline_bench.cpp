// SPDX-License-Identifier: MIT
// Measures the drag of a spline's control point. The shape reaches 64 cells from the middle of a
// lattice whose lower half is a block. Each step moves one point, restores the model and applies
// the shape again: curve, mesh, crossings, all three fields. `mesh` is the time of curve and mesh
// alone. `force` is the time of spline_forces().
//
//   spline_bench [--json] [--quick]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <kibori/spline/apply_spline.h>
#include <kibori/spline/spline_force.h>

#include "bench/workload.h"

namespace {

using namespace kibori;
using namespace kibori_bench;

SplineShape shape_of(SplineKind kind, const Vec3& middle, double radius) {
  SplineShape shape;
  shape.kind = kind;
  const auto add = [&](double x, double y, double z) {
    shape.curve.points_mm.push_back(middle + radius * Vec3(x, y, z));
  };
  switch (kind) {
    case SplineKind::extrude:
    case SplineKind::sweep:
      shape.curve.closed = true;
      for (int i = 0; i < 8; i++) {
        const double angle = std::acos(-1) / 4 * i, r = kind == SplineKind::sweep ? 0.7 : 0.95;
        add(r * std::cos(angle), r * std::sin(angle), kind == SplineKind::sweep ? 0 : -0.9);
      }
      shape.length_mm = 1.8 * radius;
      shape.radius_mm = 0.28 * radius;
      break;
    case SplineKind::revolve:
      for (int i = 0; i < 8; i++) add(0.7 + 0.25 * std::cos(1.7 * i), 0, -0.95 + 1.9 / 7 * i);
      shape.axis_point_mm = middle;
      break;
  }
  return shape;
}

struct Times {
  std::vector<double> drag, mesh, force;  // [ms]
};

Times time_drags(TriDexel& model, const SplineShape& start, double distance,
                 SplineOperation operation, int steps, int threads) {
  Times times;
  const Snapshot base = model.snapshot();
  const SplineOptions options{.threads = threads};
  const auto fail = [](const std::string& error) {
    std::fprintf(stderr, "spline_bench: %s\n", error.c_str());
    std::exit(1);
  };
  for (int i = 0; i < steps; i++) {
    SplineShape shape = start;
    const Vec3 by = distance * Vec3(std::cos(0.7 * i), shape.kind == SplineKind::revolve ? 0 : 1,
                                    shape.kind == SplineKind::extrude ? 0 : std::sin(0.7 * i));
    shape.curve.points_mm[2] += by;
    const double began = now_us();
    model.restore(base);
    const Result<SplineMesh> mesh =
        make_spline_mesh(shape, options.tolerance_cells * model.lattice().pitch_mm);
    if (!mesh) fail(mesh.error());
    const double meshed = now_us();
    const Result<Removed> done = apply_spline(model, mesh.value(), operation, 0, options);
    if (!done) fail(done.error());
    const double applied = now_us();
    std::vector<Vec3> displacements(shape.curve.points_mm.size(), Vec3::Zero());
    displacements[2] = by;
    spline_forces(mesh.value(), displacements, 1);
    times.drag.push_back((applied - began) / 1000);
    times.mesh.push_back((meshed - began) / 1000);
    times.force.push_back((now_us() - applied) / 1000);
  }
  model.restore(base);
  return times;
}

}  // namespace

int main(int argc, char** argv) {
  bool json = false, quick = false;
  for (int i = 1; i < argc; i++) {
    if (std::strcmp(argv[i], "--json") == 0)
      json = true;
    else if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else {
      std::fprintf(stderr, "spline_bench: unknown option %s\n", argv[i]);
      return 1;
    }
  }
  const double radius = quick ? 24 : 64;
  std::string out;
  for (const int nodes : {256, 512}) {
    if (quick && nodes > 256) break;
    Lattice lattice;
    lattice.nodes = Index3::Constant(nodes);
    const Vec3 middle = 0.5 * lattice.nodes.matrix().cast<double>() + Vec3(0.2, 0.3, 0.1);
    TriDexel model(lattice);
    model.fill_block({{8, 8, 8}, {nodes - 8.0, nodes - 8.0, nodes / 2.0 + 0.3}}, 0);
    for (const SplineKind kind : {SplineKind::extrude, SplineKind::revolve, SplineKind::sweep})
      for (const SplineOperation operation :
           {SplineOperation::deposit, SplineOperation::cut, SplineOperation::intersect}) {
        const SplineShape shape = shape_of(kind, middle, radius);
        const int steps = quick ? 3 : 60;
        const Times one = time_drags(model, shape, radius / 20, operation, steps, 1);
        const Times two = time_drags(model, shape, radius / 20, operation, steps, 2);
        char text[500];
        std::snprintf(
            text, sizeof text,
            json ? "{\"nodes\":%d,\"radius_cells\":%g,\"kind\":\"%s\",\"operation\":\"%s\","
                   "\"drag_p50_ms\":%.2f,\"drag_p99_ms\":%.2f,\"drag_2_threads_p50_ms\":%.2f,"
                   "\"mesh_p50_ms\":%.2f,\"force_p50_ms\":%.2f},\n "
                 : "%d^3, R = %g, %s, %s: drag p50 %.2f ms, p99 %.2f ms, on two threads p50 %.2f "
                   "ms; mesh %.2f ms; force %.2f ms\n",
            nodes, radius, std::string(name_of(kind)).c_str(),
            std::string(name_of(operation)).c_str(), median(one.drag), percentile(one.drag, 0.99),
            median(two.drag), median(one.mesh), median(one.force));
        out += text;
      }
  }
  if (json) out.erase(out.rfind(','));
  std::printf(json ? "[%s]\n" : "%s", out.c_str());
}
