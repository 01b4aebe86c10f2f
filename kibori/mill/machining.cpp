// SPDX-License-Identifier: MIT
#include <kibori/mill/machining.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <kibori/haptics/materials.h>

namespace kibori {
namespace {

// With an exponent of 1, the force would not depend on the feed.
constexpr double kMaxExponent = 0.95;

// The values come from tables of the main cutting force in turning, from the middle of their
// ranges. `k` is kc1.1 [N/mm^2], for a chip 1 mm thick. `m` is the exponent. Tables differ by 20 %,
// alloys of one metal by more, and a worn edge adds 30 %.
Material metal(const char* name, double k, double m, double density, std::array<uint8_t, 3> color) {
  Material material;
  material.name = name;
  material.k = {k, k, k};
  material.m = m;
  material.u = k;
  material.density_kg_m3 = density;
  material.color = color;
  return material;
}

const std::vector<Material>& metals() {
  static const std::vector<Material> list = {
      metal("aluminium", 780, 0.23, 2700, {200, 204, 208}),
      metal("brass", 780, 0.18, 8500, {205, 175, 95}),
      metal("steel", 1700, 0.25, 7850, {150, 155, 160}),
  };
  return list;
}

}  // namespace

Engagement engagement_of(const CutPiece& piece, const CutterDrive& drive) {
  Engagement result;
  if (!(piece.volume_mm3 > 0 && piece.path_mm > 0)) return result;
  result.section_mm2 = piece.volume_mm3 / piece.path_mm;
  if (piece.seconds > 0) result.removal_mm3_s = piece.volume_mm3 / piece.seconds;
  const double turns = drive.rpm / 60 * piece.seconds;
  if (drive.teeth > 0 && turns > 0)
    result.feed_per_tooth_mm = piece.path_mm / (turns * drive.teeth);
  if (piece.plunges) {
    result.angle_rad = 2 * std::numbers::pi;
    result.width_mm = drive.diameter_mm;
    result.depth_mm = piece.path_mm;
    result.chip_mm = result.feed_per_tooth_mm;
    return result;
  }
  if (!(drive.diameter_mm > 0)) return result;
  // A cut cannot be wider than the cutter. So the depth is at least that of a cut over the whole
  // width, even if rounding makes the measured depth smaller.
  result.depth_mm = std::max(piece.depth_mm, result.section_mm2 / drive.diameter_mm);
  if (!(result.depth_mm > 0)) return result;
  result.width_mm = result.section_mm2 / result.depth_mm;
  const double share = std::clamp(2 * result.width_mm / drive.diameter_mm, 0.0, 2.0);
  result.angle_rad = std::acos(1 - share);
  if (result.angle_rad > 0) result.chip_mm = result.feed_per_tooth_mm * share / result.angle_rad;
  return result;
}

std::optional<CuttingForce> cutting_force(const Engagement& engagement, const CutterDrive& drive,
                                          const Material& material) {
  if (!(engagement.chip_mm > 0 && drive.rpm > 0 && drive.diameter_mm > 0)) return std::nullopt;
  const double k = mean_cutting_energy(material);
  if (!(k > 0)) return std::nullopt;
  CuttingForce result;
  result.resistance_n_mm2 = k * std::pow(std::max(engagement.chip_mm, kMinChip), -material.m);
  // N/mm^2 mm^3/s = N mm/s = mW
  const double power_mw = result.resistance_n_mm2 * engagement.removal_mm3_s;
  result.power_w = power_mw / 1000;
  result.force_n = power_mw / (std::numbers::pi * drive.diameter_mm * drive.rpm / 60);
  return result;
}

double feed_factor_for(double ratio, const Engagement& engagement, const Material& material) {
  const double m = std::min(material.m, kMaxExponent), h = engagement.chip_mm;
  // f max(h f, kMinChip)^(-m) = wanted
  const double wanted = ratio * std::pow(std::max(h, kMinChip), -m);
  const double thick = std::pow(wanted * std::pow(h, m), 1 / (1 - m));
  return h * thick >= kMinChip ? thick : wanted * std::pow(kMinChip, m);
}

const Material* machining_material(const std::string& name) {
  for (const Material& material : metals())
    if (material.name == name) return &material;
  return known_material(name);
}

std::vector<std::string> machining_materials() {
  std::vector<std::string> names;
  for (const Material& material : metals()) names.push_back(material.name);
  for (const Material& material : known_materials()) names.push_back(material.name);
  return names;
}

}  // namespace kibori
