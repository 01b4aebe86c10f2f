// SPDX-License-Identifier: MIT
#include <kibori/batch/body_report.h>

#include <cstdio>

#include <nlohmann/json.hpp>

#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/body/pieces.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

nlohmann::ordered_json list(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::vector<BodyReport> report_bodies(const Bodies& bodies, int threads) {
  std::vector<BodyReport> reports;
  for (const Body& body : bodies.all) {
    BodyReport report;
    report.body = body;
    report.volume_mm3 = body.model.volume_mm3();
    report.pieces = find_pieces(body.model).all().size();
    report.mesh = mesh_info(extract_surface(body.model, threads));
    reports.push_back(std::move(report));
  }
  return reports;
}

std::string bodies_text(const std::vector<BodyReport>& reports) {
  std::string text = "  body    volume mm3  pieces  closed  name\n";
  for (const BodyReport& report : reports) {
    char line[120];
    std::snprintf(line, sizeof line, "%6d  %12.6g  %6zu  %6s  ", report.body.id, report.volume_mm3,
                  report.pieces, report.mesh.closed ? "yes" : "no");
    text += line + sanitize_message(report.body.name);
    if (!report.body.visible) text += "  (hidden)";
    if (report.body.locked) text += "  (locked)";
    text += "\n";
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
         {"hash", hash_text(report.body.model.content_hash())}});
  }
  return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kibori
