// SPDX-License-Identifier: MIT
#include <kibori/measure/mass.h>

#include <algorithm>

#include <kibori/base/check.h>

namespace kibori {
namespace {

struct Part {
  double volume = 0;           // lattice units^3
  Vec3 moment = Vec3::Zero();  // about the lattice's origin
};

}  // namespace

MassProperties mass_of(const Snapshot& model, const std::vector<double>& density_kg_m3) {
  KIBORI_CHECK(!density_kg_m3.empty());
  const Lattice& lattice = model.lattice;
  std::vector<Part> parts(density_kg_m3.size());
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis);
    const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
    for (int j = field.v_begin(); j < field.v_end(); j++)
      for (int i = field.u_begin(); i < field.u_end(); i++)
        field.for_spans(i, j, [&](const Span& span) {
          Part& part = parts[std::min<size_t>(span.material, parts.size() - 1)];
          const RayVolume piece = field.ray_volume(i, j, span, model.field(Axis::z));
          const auto add = [&](double volume, double depth) {
            part.volume += volume;
            part.moment[u] += volume * (i + 0.5);
            part.moment[v] += volume * (j + 0.5);
            part.moment[d] += volume * depth;
          };
          if (axis == Axis::z) add(piece.nodes(), 0.5 * (double{piece.first} + piece.last));
          add(piece.correction_lo, 0.5 * (double{piece.first} + span.in));
          add(piece.correction_hi, 0.5 * (double{piece.last} + span.out));
        });
  }
  MassProperties all;
  const double h = lattice.pitch_mm, cell = h * h * h;
  bool known = true;
  for (size_t i = 0; i < parts.size(); i++) {
    all.volume_mm3.push_back(cell * parts[i].volume);
    known &= parts[i].volume == 0 || density_kg_m3[i] > 0;
  }
  double sum = 0;
  Vec3 moment = Vec3::Zero();
  for (size_t i = 0; i < parts.size(); i++) {
    const double weight = known ? density_kg_m3[i] : 1;
    sum += weight * parts[i].volume;
    moment += weight * parts[i].moment;
  }
  if (known) all.mass_g = 1e-6 * cell * sum;  // kg/m^3 = 1e-6 g/mm^3
  if (sum > 0) all.centre_mm = lattice.to_mm(LatticePoint{moment / sum});
  return all;
}

}  // namespace kibori
