// SPDX-License-Identifier: MIT
#include <kibori/report/mesh_report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <nlohmann/json.hpp>

#include <kibori/base/percent.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/run/documents.h>
#include <kibori/scene/stock.h>
#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

// Faces that are nearly opposite (170 degrees) are the two sides of a wall. The faces of a wedge
// are not.
constexpr double kOpposite = -0.985;
// A wall is measured by the fields whose rays meet it at a small angle to its normal. This is the
// minimum cosine of that angle. The cosine of the best field is never less (1/sqrt 3).
constexpr double kFacing = 0.577;

ThinWalls thin_walls(const Snapshot& model, double threshold_mm) {
  const double pitch = model.lattice.pitch_mm;
  ThinWalls walls{threshold_mm, pitch, std::numeric_limits<double>::infinity(), Vec3::Zero(), 0};
  double all = 0, thin = 0;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis);
    for (int v = field.v_begin(); v < field.v_end(); v++)
      for (int u = field.u_begin(); u < field.u_end(); u++)
        field.for_spans(u, v, [&](const Span& s) {
          const Vec3 near = decode_normal(s.normal_in, axis, false),
                     far = decode_normal(s.normal_out, axis, true);
          const double cosine = std::abs(near[depth_index(axis)]);
          if (near.dot(far) > kOpposite || cosine < kFacing) return;
          const double thickness =
              (static_cast<double>(s.out) - static_cast<double>(s.in)) * cosine * pitch;
          const double area = 1 / cosine;
          all += area;
          if (thickness < threshold_mm) thin += area;
          if (thickness >= walls.thinnest_mm) return;
          walls.thinnest_mm = thickness;
          LatticePoint p;
          p.units[u_index(axis)] = u + 0.5;
          p.units[v_index(axis)] = v + 0.5;
          p.units[depth_index(axis)] =
              0.5 * (static_cast<double>(s.in) + static_cast<double>(s.out));
          walls.at_mm = model.lattice.to_mm(p);
        });
  }
  walls.share = all > 0 ? thin / all : 0;
  return walls;
}

// A face that is at most this share of the height above the lowest point is on the bed.
constexpr double kOnBed = 1e-4;

// Surfaces have float32 vertices. If a mesh is too far from the origin for this precision, moves it
// to the origin, and returns its old position. Other meshes stay, so that all reported digits are
// those of the file.
Vec3 near_origin(TriangleMesh& mesh) {
  // Share of the longest side, as in formats/text.cpp.
  constexpr double kMaxRounding = 1e-6;
  const Box box = mesh.bounds();
  if (box.empty()) return Vec3::Zero();
  const double max = kMaxRounding * box.size().maxCoeff();
  const bool near = std::ranges::all_of(mesh.vertices, [&](const Vec3& p) {
    return (p.cast<float>().cast<double>() - p).cwiseAbs().maxCoeff() <= max;
  });
  if (near) return Vec3::Zero();
  for (Vec3& p : mesh.vertices) p -= box.min;
  return box.min;
}

Overhangs overhangs_of(const Surface& surface, double threshold_deg) {
  Overhangs found{threshold_deg};
  const auto at = [&](uint32_t v) {
    const auto& p = surface.vertices[v].position;
    return Vec3(p[0], p[1], p[2]);
  };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const SurfaceTriangle& t : surface.triangles)
    for (const uint32_t v : t) {
      low = std::min(low, at(v).z());
      high = std::max(high, at(v).z());
    }
  const double bed = low + kOnBed * (high - low),
               steepest = std::sin(threshold_deg * std::numbers::pi / 180);
  double all = 0;
  for (const SurfaceTriangle& t : surface.triangles) {
    const Vec3 a = at(t[0]), b = at(t[1]), c = at(t[2]), twice = (b - a).cross(c - a);
    const double area = twice.norm() / 2;
    all += area;
    if (std::max({a.z(), b.z(), c.z()}) <= bed) continue;
    // Slightly more than the threshold, so that a face of exactly that angle does not count.
    if (-twice.z() / 2 > area * (steepest + 1e-6)) found.area_mm2 += area;
  }
  found.share = all > 0 ? found.area_mm2 / all : 0;
  return found;
}

}  // namespace

Result<MeshReport> report_mesh(const std::filesystem::path& path,
                               const MeshReportOptions& options) {
  MeshReport report;
  Result<TriangleMesh> mesh = read_mesh_or_document(path, options.threads, &report.notes);
  if (!mesh) return Error{mesh.error()};
  const Vec3 origin = near_origin(mesh.value());
  const Surface surface = surface_of_mesh(mesh.value());
  report.info = mesh_info(surface, mesh.value().triangles.size() - surface.triangles.size());
  report.info.bounds.min += origin;
  report.info.bounds.max += origin;
  report.info.centroid_mm += origin;
  report.overhangs = overhangs_of(surface, options.overhang_deg);
  const double longest = mesh.value().bounds().size().maxCoeff();
  const double pitch = options.pitch_mm.value_or(longest / 256);
  if (!(pitch > 0)) return report;
  const Result<MeshStock> stock =
      stock_of_mesh(mesh.value(), pitch, 2 * pitch, 0, options.threads, false);
  if (stock) {
    report.walls = thin_walls(stock.value().model->snapshot(), options.wall_mm);
    report.walls->at_mm += origin;
  } else {
    report.no_walls = stock.error();
  }
  return report;
}

std::string mesh_report_text(const MeshReport& report) {
  const MeshInfo& i = report.info;
  const Vec3 size = i.triangles ? i.bounds.size() : Vec3(Vec3::Zero()),
             low = i.triangles ? i.bounds.min : size;
  char text[1400];
  int length = std::snprintf(
      text, sizeof text,
      "size         %.6g x %.6g x %.6g mm\nlower corner %.6g, %.6g, %.6g mm\nvolume       %.6g "
      "mm3\narea         %.6g "
      "mm2\ncentroid     %.6g, %.6g, %.6g mm\ntriangles    %zu\ncomponents   %zu\nclosed       "
      "%s\nmanifold     %s\n",
      size.x(), size.y(), size.z(), low.x(), low.y(), low.z(), i.volume_mm3, i.area_mm2,
      i.centroid_mm.x(), i.centroid_mm.y(), i.centroid_mm.z(), i.triangles, i.components,
      i.closed ? "yes" : "no", i.manifold ? "yes" : "no");
  const auto add = [&](auto... values) {
    length += std::snprintf(text + length, sizeof text - static_cast<size_t>(length), values...);
  };
  if (i.open_edges) add("open edges   %zu\n", i.open_edges);
  if (i.overfull_edges) add("edges of more than two triangles  %zu\n", i.overfull_edges);
  if (i.degenerate) add("degenerate   %zu triangles\n", i.degenerate);
  add("overhangs    %.6g mm2, %s of the surface, lean more than %g degrees\n",
      report.overhangs.area_mm2, percent(report.overhangs.share).c_str(),
      report.overhangs.threshold_deg);
  if (!report.walls)
    add("walls        not measured: %.300s\n",
        report.no_walls.empty() ? "no extent" : report.no_walls.c_str());
  else if (!std::isfinite(report.walls->thinnest_mm))
    add("walls        %s\n", "none with parallel sides");
  else
    add("walls        thinnest %.3g mm, at %.6g, %.6g, %.6g mm; %s thinner than %g mm\n",
        report.walls->thinnest_mm, report.walls->at_mm.x(), report.walls->at_mm.y(),
        report.walls->at_mm.z(), percent(report.walls->share).c_str(), report.walls->threshold_mm);
  std::string all(text);
  for (const std::string& note : report.notes) all.append("note         ").append(note) += '\n';
  return all;
}

std::string mesh_report_json(const MeshReport& report) {
  const MeshInfo& i = report.info;
  const auto list = [](const Vec3& v) {
    return nlohmann::ordered_json::array({v.x(), v.y(), v.z()});
  };
  nlohmann::ordered_json json = {
      {"size_mm", list(i.triangles ? i.bounds.size() : Vec3(Vec3::Zero()))},
      {"lower_corner_mm", list(i.triangles ? i.bounds.min : Vec3(Vec3::Zero()))},
      {"volume_mm3", i.volume_mm3},
      {"area_mm2", i.area_mm2},
      {"centroid_mm", list(i.centroid_mm)},
      {"triangles", i.triangles},
      {"components", i.components},
      {"closed", i.closed},
      {"manifold", i.manifold},
      {"open_edges", i.open_edges},
      {"overfull_edges", i.overfull_edges},
      {"degenerate_triangles", i.degenerate},
      {"overhangs",
       {{"threshold_deg", report.overhangs.threshold_deg},
        {"area_mm2", report.overhangs.area_mm2},
        {"share", report.overhangs.share}}},
      {"thin_walls", nullptr}};
  if (report.walls) {
    const ThinWalls& w = *report.walls;
    const bool any = std::isfinite(w.thinnest_mm);
    json["thin_walls"] = {{"threshold_mm", w.threshold_mm},
                          {"pitch_mm", w.pitch_mm},
                          {"thinnest_mm", any ? nlohmann::ordered_json(w.thinnest_mm) : nullptr},
                          {"at_mm", any ? list(w.at_mm) : nullptr},
                          {"share", w.share}};
  }
  json["notes"] = report.notes;
  // A file's name may not be UTF-8.
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kibori
