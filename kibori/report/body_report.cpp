// SPDX-License-Identifier: MIT
#include <kibori/report/body_report.h>

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/body/pieces.h>
#include <kibori/edit/edit.h>
#include <kibori/haptics/materials.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

nlohmann::ordered_json list(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// Number of points on a body's surface from which distances are measured.
constexpr int64_t kRemainsSamples = 100000;

Result<std::optional<Remains>> remains_of(const Body& body, const Surface& surface,
                                          const BodyList& bodies, int threads) {
  std::optional<Remains> none;
  if (body.no_go || surface.triangles.empty()) return none;
  const Result<std::shared_ptr<const NoGo>> no_go = no_go_of(bodies, body.id);
  if (!no_go) return Error{no_go.error()};
  if (!no_go.value()) return none;
  Removed within;
  contact(TriDexel(body.model, body.material_bounds), no_go.value()->solid(), {}, within);
  const double h = body.model.lattice.pitch_mm;
  const Result<Distance> distance =
      distance_from_to(surface, extract_surface(no_go.value()->model().snapshot(), threads),
                       kRemainsSamples, threads);
  if (!distance) return Error{distance.error()};
  return std::optional<Remains>(
      {std::max(0.0, body.model.volume_mm3() - within.volume() * h * h * h), distance.value()});
}

}  // namespace

Result<std::vector<BodyReport>> report_bodies(const std::vector<Body>& some, const BodyList& all,
                                              const std::vector<Material>& materials, int threads) {
  std::vector<BodyReport> reports;
  std::vector<double> densities;
  densities.reserve(materials.size() + 1);
  for (const Material& m : materials) densities.push_back(m.density_kg_m3);
  if (densities.empty()) densities.push_back(0);
  for (const Body& body : some) {
    BodyReport report;
    report.body = body;
    report.volume_mm3 = body.model.volume_mm3();
    report.mass = mass_of(body.model, densities);
    report.pieces = find_pieces(body.model).all().size();
    const Surface surface = extract_surface(body.model, threads);
    report.mesh = mesh_info(surface);
    Result<std::optional<Remains>> remains = remains_of(body, surface, all, threads);
    if (!remains) return Error{remains.error()};
    report.remains = remains.value();
    reports.push_back(std::move(report));
  }
  return reports;
}

std::string bodies_text(const std::vector<BodyReport>& reports) {
  std::string text = "  body    volume mm3  pieces  closed  name\n";
  for (const BodyReport& report : reports) {
    char line[160];
    std::snprintf(line, sizeof line, "%6d  %12.6g  %6zu  %6s  ", report.body.id, report.volume_mm3,
                  report.pieces, report.mesh.closed ? "yes" : "no");
    text += line + sanitize_message(report.body.name);
    if (!report.body.visible) text += "  (hidden)";
    if (report.body.locked) text += "  (locked)";
    if (report.body.no_go) text += "  (protected)";
    text += "\n";
    if (report.volume_mm3 > 0) {
      const Vec3 centre = report.body.pose.to_world(report.mass.centre_mm);
      std::snprintf(line, sizeof line, "%6s  %12s", "",
                    report.mass.mass_g > 0 ? "" : "mass unknown");
      if (report.mass.mass_g > 0)
        std::snprintf(line, sizeof line, "%6s  %10.4g g", "", report.mass.mass_g);
      text += line;
      std::snprintf(line, sizeof line, "  centre of gravity %.4g %.4g %.4g mm\n", centre.x(),
                    centre.y(), centre.z());
      text += line;
    }
    if (!report.remains) continue;
    const Remains& remains = *report.remains;
    std::snprintf(line, sizeof line,
                  "%6s  %12.6g  outside the protected region; its surface is at most %.4g mm away "
                  "from it, %.4g mm on average\n",
                  "", remains.volume_mm3, remains.distance.max, remains.distance.mean);
    text += line;
  }
  return text;
}

std::string bodies_json_text(const std::vector<BodyReport>& reports) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const BodyReport& report : reports) {
    const Pose& pose = report.body.pose;
    const bool empty = report.mesh.bounds.empty();
    all.push_back(
        {{"id", report.body.id},
         {"name", report.body.name},
         {"volume_mm3", report.volume_mm3},
         {"mass_g", report.mass.mass_g > 0 ? nlohmann::ordered_json(report.mass.mass_g)
                                           : nlohmann::ordered_json()},
         {"centre_mm", list(pose.to_world(report.mass.centre_mm))},
         {"closed", report.mesh.closed},
         {"manifold", report.mesh.manifold},
         {"pieces", report.pieces},
         {"triangles", report.mesh.triangles},
         {"area_mm2", report.mesh.area_mm2},
         {"bounds_mm",
          {list(empty ? Vec3(Vec3::Zero()) : report.mesh.bounds.min),
           list(empty ? Vec3(Vec3::Zero()) : report.mesh.bounds.max)}},
         {"pose",
          {{"tip_mm", list(pose.tip)},
           {"axes", {list(pose.frame.col(0)), list(pose.frame.col(1)), list(pose.frame.col(2))}}}},
         {"visible", report.body.visible},
         {"locked", report.body.locked},
         {"no_go", report.body.no_go},
         {"hash", hash_text(report.body.model.content_hash())}});
    if (!report.remains) continue;
    all.back()["remains_mm3"] = report.remains->volume_mm3;
    all.back()["remains_max_mm"] = report.remains->distance.max;
    all.back()["remains_mean_mm"] = report.remains->distance.mean;
  }
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kibori
