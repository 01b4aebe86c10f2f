// SPDX-License-Identifier: MIT
#include <kibori/scene/stock.h>

#include <cmath>
#include <cstdio>

#include <kibori/base/memory.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/nrrd.h>
#include <kibori/scene/relief.h>
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

namespace {

// Each label's voxels of its material.
Result<std::unique_ptr<TriDexel>> volume_stock(const Stock& stock, const StockOptions& options) {
  const Result<LabelVolume> read = read_nrrd(stock.mesh_path);
  if (!read) return Error{"volume " + read.error()};
  const LabelVolume& volume = read.value();
  const std::vector<uint16_t> labels = labels_of(volume);
  if (labels.empty()) return Error{"volume holds nothing but air"};
  for (const uint16_t label : labels) {
    if (stock.labels.contains(label)) continue;
    const auto name = volume.names.find(label);
    return Error{"labels does not say which material label " + std::to_string(label) +
                 (name == volume.names.end() ? "" : " (" + name->second + ")") + " is of"};
  }
  return stock_of_labels(volume, stock.labels, stock.pitch_mm, stock.room_mm, options.threads);
}

// All of one material, but for a volume.
Result<std::unique_ptr<TriDexel>> plain_stock(const Stock& stock, const std::string& scene_file,
                                              const StockOptions& options) {
  const auto wrong = [&](const std::string& what) {
    std::string where = scene_file;
    if (stock.line > 0) where.append(":").append(std::to_string(stock.line));
    return Error{where.append(": [stock] ").append(what)};
  };
  if (stock.kind == Stock::Kind::mesh || stock.kind == Stock::Kind::relief) {
    const bool relief = stock.kind == Stock::Kind::relief;
    const std::string what = relief ? "relief " : "mesh ",
                      name = what + stock.mesh_path.string() + ": ";
    Result<TriangleMesh> read =
        relief ? read_relief(stock.mesh_path,
                             {stock.width_mm, stock.height_mm, stock.base_mm, stock.invert},
                             stock.pitch_mm)
               : read_mesh(stock.mesh_path);
    if (!read) return wrong(what + read.error());
    TriangleMesh mesh = std::move(read).value();
    const Mat3 turn = rotation(stock.orientation);
    for (Vec3& p : mesh.vertices) p = turn * p;
    const Box box = mesh.bounds();
    const double longest = box.size().maxCoeff();
    if (!(longest > 0)) return wrong(name + "has no extent");
    if (stock.fit_mm && !(*stock.fit_mm > 0 && std::isfinite(*stock.fit_mm)))
      return wrong("fit must be a number of mm above 0");
    const double scale = stock.fit_mm ? *stock.fit_mm / longest : 1;
    for (Vec3& p : mesh.vertices) p = (p - box.min) * scale;
    Result<MeshStock> made =
        stock_of_mesh(mesh, stock.pitch_mm, stock.room_mm.value_or(0.1 * longest * scale),
                      stock.material, options.threads, options.force);
    if (!made) return wrong(name + made.error());
    const ScanReport& report = made.value().report;
    if (report.repaired() && options.warning)
      options.warning(stock.mesh_path.string() + ": " + report.warning());
    if (!(made.value().model->volume_mm3() > 0))
      return wrong("holds no material at this pitch; use a finer one");
    return std::move(made.value().model);
  }
  if (stock.kind == Stock::Kind::volume) {
    Result<std::unique_ptr<TriDexel>> made = volume_stock(stock, options);
    return made ? std::move(made) : wrong(made.error());
  }
  const Vec3 size = stock.size_mm;
  if (!(size.array() > 0).all()) return wrong("must be larger than 0 mm along x, y and z");
  Result<Lattice> lattice =
      make_lattice(size, stock.pitch_mm, stock.room_mm.value_or(0.1 * size.maxCoeff()));
  if (!lattice) return wrong(lattice.error());
  if (stock.kind != Stock::Kind::block)
    if (const Status fits = check_memory(lattice.value(), false); !fits) return wrong(fits.error());
  auto model = std::make_unique<TriDexel>(lattice.value());
  EditOptions edit;
  edit.threads = options.threads;
  Removed added;
  const auto put = [&](const Tool& tool, const Vec3& tip) {
    const SweptTool solid(tool, Pose{tip, Mat3::Identity()}, Vec3::Zero(), lattice.value());
    deposit(*model, solid, stock.material, edit, added);
  };
  switch (stock.kind) {
    case Stock::Kind::block:
      model->fill_block({Vec3::Zero(), size}, stock.material);
      break;
    case Stock::Kind::sphere:
      put(BallTool{size.x() / 2}, Vec3(size.x() / 2, size.x() / 2, 0));
      break;
    case Stock::Kind::cylinder:
      put(Flat{size.x() / 2, size.z()}, Vec3(size.x() / 2, size.x() / 2, 0));
      break;
    case Stock::Kind::mesh:
    case Stock::Kind::relief:
    case Stock::Kind::volume:
      break;  // above
  }
  if (!(model->volume_mm3() > 0)) return wrong("holds no material at this pitch; use a finer one");
  return model;
}

}  // namespace

Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options) {
  Result<std::unique_ptr<TriDexel>> made = plain_stock(stock, scene_file, options);
  if (!made) return made;
  TriDexel& model = *made.value();
  EditOptions edit;
  edit.threads = options.threads;
  for (const StockLayer& layer : stock.layers) {
    const SweptTool shape(layer.shape, layer.pose, Vec3::Zero(), model.lattice());
    if (!change_material(model, shape.solid(), layer.material, edit)) {
      std::string where = scene_file;
      if (layer.line > 0) where.append(":").append(std::to_string(layer.line));
      return Error{where + ": [layer] holds nothing of the stock; move it, or make it larger"};
    }
  }
  return made;
}

}  // namespace kibori
