// SPDX-License-Identifier: MIT
#include "apps/studio/print_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kibori::studio {
namespace {

constexpr double kNoWall = std::numeric_limits<double>::infinity();

// The colour of each fault, as 0xAABBGGRR. All kinds of colour vision distinguish them (Okabe and
// Ito).
constexpr std::array<uint32_t, 4> kPrintColors{0xffd9d9d9, 0xff00aff0, 0xff005ed5, 0xffa779cc};

PrintCheckOptions standing(PrintCheckOptions options, const Pose& pose) {
  options.up = pose.frame.transpose() * Vec3::UnitZ();
  return options;
}

}  // namespace

PrintMap::PrintMap(const Body& body, const PrintCheckOptions& options, StepId step)
    : body_(body.id),
      pose_(body.pose),
      step_(step),
      check_(body.model, standing(options, body.pose)) {}

bool PrintMap::is_of(const kibori::BodyList& bodies, BodyId worked_on, StepId step) const {
  const Body* const body = bodies.find(worked_on);
  return worked_on == body_ && step == step_ && body && body->pose.tip == pose_.tip &&
         body->pose.frame == pose_.frame;
}

SurfaceChunk PrintMap::paint(SurfaceChunk chunk, const Index3& at) {
  Part part;
  part.thinnest = kNoWall;
  std::vector<PrintFault> faults;
  faults.reserve(chunk.vertices.size());
  for (SurfaceVertex& v : chunk.vertices) {
    faults.push_back(check_.at(v));
    v.paint = kPrintColors[static_cast<size_t>(faults.back())];
    part.thinnest = std::min(part.thinnest, check_.thickness_mm(v));
  }
  for (const SurfaceTriangle& t : chunk.triangles) {
    const auto place = [&](uint32_t v) {
      const auto& p = chunk.vertices[v].position;
      return Vec3(p[0], p[1], p[2]);
    };
    const Vec3 a = place(t[0]), b = place(t[1]), c = place(t[2]);
    // Each corner gets a third of the area.
    for (const uint32_t v : t)
      part.area[static_cast<size_t>(faults[v])] += (b - a).cross(c - a).norm() / 6;
  }
  if (chunk.triangles.empty())
    parts_.erase(at);
  else
    parts_[at] = part;
  return chunk;
}

std::vector<uint8_t> PrintMap::message(double) const {
  PrintFaults message;
  double thinnest = kNoWall;
  for (const auto& [at, part] : parts_) {
    message.overhang += part.area[static_cast<size_t>(PrintFault::overhang)];
    message.thin += part.area[static_cast<size_t>(PrintFault::thin)];
    for (const double area : part.area) message.area += area;
    thinnest = std::min(thinnest, part.thinnest);
  }
  message.thinnest = std::isfinite(thinnest) ? thinnest : 0;
  message.pieces = static_cast<uint32_t>(check_.pieces());
  return encode(message);
}

}  // namespace kibori::studio
