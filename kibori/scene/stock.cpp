// SPDX-License-Identifier: MIT
#include <kibori/scene/stock.h>

#include <cmath>
#include <cstdio>

#include <kibori/base/memory.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/dexel_solid.h>
#include <kibori/solid/grid_solid.h>

namespace kibori {

Status check_memory(const Lattice& lattice, bool mesh) {
  // When every tile holds something of its own, and the import besides.
  double need = 0;
  for (int i = 0; i < 3; i++) {
    const double rays = static_cast<double>(lattice.nodes[i]) * lattice.nodes[(i + 1) % 3];
    need += rays / kTileRays * static_cast<double>(sizeof(Tile)) + (mesh ? rays * 40 : 0);
  }
  const double there = available_bytes();
  if (!(there > 0 && need > there)) return Ok{};
  char text[200];
  std::snprintf(text, sizeof text,
                "pitch %g mm would take about %.1f GB and %.1f GB are free; use a coarser pitch "
                "(%.3g mm fits)",
                lattice.pitch_mm, need / 1e9, there / 1e9,
                lattice.pitch_mm * std::sqrt(need / (0.8 * there)));
  return Error{text};
}

Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force) {
  const Box box = mesh.bounds();
  Result<Lattice> lattice = make_lattice(box.size(), pitch_mm, room_mm);
  if (!lattice) return Error{lattice.error()};
  Lattice placed = lattice.value();
  placed.origin_mm += box.min;
  const double farthest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (farthest > kMaxFromOrigin * pitch_mm) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "reaches %.4g mm from the origin, and at pitch %g mm only %.4g mm can be told apart; move "
        "it nearer or "
        "use a coarser pitch",
        farthest, pitch_mm, kMaxFromOrigin * pitch_mm);
    return Error{text};
  }
  if (const Status fits = check_memory(placed, true); !fits) return Error{fits.error()};
  MeshStock stock{std::make_unique<TriDexel>(placed), {}};
  Result<ScanReport> report = scan_convert(*stock.model, mesh, material, {force, threads});
  if (!report) return Error{report.error()};
  stock.report = report.value();
  return stock;
}

bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit) {
  TriDexel within(model.snapshot(), model.material_bounds());
  Removed changed;
  intersect(within, solid, edit, changed);
  if (!(within.volume_mm3() > 0)) return false;
  const DexelSolid part(within.snapshot(), within.material_bounds());
  cut(model, part, edit, changed);
  deposit(model, part, material, edit, changed);
  return true;
}

Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads) {
  const std::vector<uint16_t> labels = labels_of(volume);
  KIBORI_CHECK(!labels.empty());
  const Vec3 size = volume.size_mm();
  Result<Lattice> lattice = make_lattice(size, pitch_mm, room_mm.value_or(0.1 * size.maxCoeff()));
  if (!lattice) return Error{lattice.error()};
  if (const Status fits = check_memory(lattice.value(), false); !fits) return Error{fits.error()};
  auto model = std::make_unique<TriDexel>(lattice.value());
  EditOptions edit;
  edit.threads = threads;
  Removed added;
  const LabelShapes shapes(volume);
  const ShapeGrid whole = shapes.whole();
  const uint16_t first = labels.front();
  deposit(*model, GridSolid(whole, Vec3::Zero(), lattice.value()), materials.at(first), edit,
          added);
  for (const uint16_t label : labels) {
    if (label == first) continue;
    const ShapeGrid share = shapes.share_of(label);
    change_material(*model, GridSolid(share, Vec3::Zero(), lattice.value()), materials.at(label),
                    edit);
  }
  if (!(model->volume_mm3() > 0))
    return Error{"volume holds no material at this pitch; use a finer one"};
  return model;
}

}  // namespace kibori
