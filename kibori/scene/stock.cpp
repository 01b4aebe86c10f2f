// SPDX-License-Identifier: MIT
#include <kibori/scene/stock.h>

#include <cmath>
#include <cstdio>

#include <kibori/base/memory.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/volume_file.h>
#include <kibori/geometry/mesh_repair.h>
#include <kibori/solid/dexel_solid.h>
#include <kibori/solid/grid_solid.h>

namespace kibori {

Status check_memory(const Lattice& lattice, bool mesh) {
  // The estimate assumes that tiles share no memory. Scan conversion needs about 40 bytes per ray.
  double need = 0;
  for (int i = 0; i < 3; i++) {
    const double rays = static_cast<double>(lattice.nodes[i]) * lattice.nodes[(i + 1) % 3];
    need += rays / kTileRays * static_cast<double>(sizeof(Tile)) + (mesh ? rays * 40 : 0);
  }
  const double there = available_bytes();
  if (!(there > 0 && need > there)) return Ok{};
  char text[200];
  std::snprintf(text, sizeof text,
                "pitch %g mm needs about %.1f GB, and %.1f GB are free; use a coarser pitch "
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
  lattice.value().origin_mm += box.min;
  return stock_of_mesh(mesh, lattice.value(), material, threads, force);
}

Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, const Lattice& lattice, uint8_t material,
                                int threads, bool force) {
  const Box box = mesh.bounds();
  const double farthest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (farthest > kMaxFromOrigin * lattice.pitch_mm) {
    char text[200];
    std::snprintf(
        text, sizeof text,
        "reaches %.4g mm from the origin, and at pitch %g mm the limit is %.4g mm; move it nearer "
        "to the origin or use a coarser pitch",
        farthest, lattice.pitch_mm, kMaxFromOrigin * lattice.pitch_mm);
    return Error{text};
  }
  if (const Status fits = check_memory(lattice, true); !fits) return Error{fits.error()};
  MeshStock stock{std::make_unique<TriDexel>(lattice), {}, {}};
  TriangleMesh sound;
  if (std::optional<MeshRepair> repair = repair_mesh(mesh)) {
    stock.repairs = repair->warning();
    sound = {mesh.vertices, std::move(repair->triangles)};
  }
  Result<ScanReport> report =
      scan_convert(*stock.model, stock.repairs.empty() ? mesh : sound, material, {force, threads});
  if (!report) return Error{report.error()};
  stock.report = report.value();
  return stock;
}

std::string MeshStock::warning() const {
  const std::string scanned = report.warning();
  return repairs.empty() || scanned.empty() ? repairs + scanned : repairs + "; " + scanned;
}

bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit) {
  TriDexel within(model.snapshot(), model.material_bounds());
  Removed changed;
  intersect(within, solid, edit, changed);
  if (within.empty()) return false;
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
  if (model->empty()) return Error{"volume has no material at this pitch; use a finer one"};
  return model;
}

Vec3 size_mm(const StockShape& shape) {
  if (const auto* block = std::get_if<StockBlock>(&shape)) return block->size_mm;
  if (const auto* sphere = std::get_if<StockSphere>(&shape))
    return Vec3::Constant(sphere->diameter_mm);
  if (const auto* cylinder = std::get_if<StockCylinder>(&shape))
    return {cylinder->diameter_mm, cylinder->diameter_mm, cylinder->height_mm};
  return Vec3::Zero();
}

const std::filesystem::path* file_of(const Stock& stock) {
  return std::visit(
      [](const auto& shape) -> const std::filesystem::path* {
        if constexpr (requires { shape.file; })
          return &shape.file;
        else
          return nullptr;
      },
      stock.shape);
}

std::filesystem::path* file_of(Stock& stock) {
  return const_cast<std::filesystem::path*>(file_of(static_cast<const Stock&>(stock)));
}

namespace {

using Made = Result<std::unique_ptr<TriDexel>>;
constexpr const char* kNothing = "has no material at this pitch; use a finer one";

// Makes an empty model around the shape, and fills it by f(model, size).
template <class F>
Made put_in(const Stock& stock, F&& f) {
  const Vec3 size = size_mm(stock.shape);
  if (!(size.array() > 0).all()) return Error{"must be larger than 0 mm along x, y and z"};
  const Result<Lattice> lattice =
      make_lattice(size, stock.pitch_mm, stock.room_mm.value_or(0.1 * size.maxCoeff()));
  if (!lattice) return Error{lattice.error()};
  if (!std::holds_alternative<StockBlock>(stock.shape))
    if (const Status fits = check_memory(lattice.value(), false); !fits) return Error{fits.error()};
  auto model = std::make_unique<TriDexel>(lattice.value());
  f(*model, size);
  if (model->empty()) return Error{kNothing};
  return model;
}

// Deposits a tool at rest. Its tip is in the middle of the bottom of the stock's bounds.
void put(const Tool& tool, TriDexel& model, const Vec3& size, const Stock& stock, int threads) {
  EditOptions edit;
  edit.threads = threads;
  Removed added;
  const Pose pose{{size.x() / 2, size.x() / 2, 0}, Mat3::Identity()};
  const SweptTool solid(tool, pose, Vec3::Zero(), model.lattice());
  deposit(model, solid, stock.material, edit, added);
}

Made make(const StockBlock&, const Stock& stock, const StockOptions&) {
  return put_in(stock, [&](TriDexel& model, const Vec3& size) {
    model.fill_block({Vec3::Zero(), size}, stock.material);
  });
}

Made make(const StockSphere&, const Stock& stock, const StockOptions& options) {
  return put_in(stock, [&](TriDexel& model, const Vec3& size) {
    put(BallTool{size.x() / 2}, model, size, stock, options.threads);
  });
}

Made make(const StockCylinder&, const Stock& stock, const StockOptions& options) {
  return put_in(stock, [&](TriDexel& model, const Vec3& size) {
    put(Flat{size.x() / 2, size.z()}, model, size, stock, options.threads);
  });
}

// Returns a model of the mesh, with its lower corner moved to the origin. Errors begin with `name`,
// and warnings with `file`.
Made make_of(TriangleMesh mesh, const std::optional<double>& fit_mm, const std::string& name,
             const std::string& file, const Stock& stock, const StockOptions& options) {
  const Box box = mesh.bounds();
  const double longest = box.size().maxCoeff();
  if (!(longest > 0)) return Error{name + "has no extent; use a solid mesh"};
  if (fit_mm && !(*fit_mm > 0 && std::isfinite(*fit_mm)))
    return Error{"fit must be a finite number of mm above 0"};
  const double scale = fit_mm ? *fit_mm / longest : 1;
  for (Vec3& p : mesh.vertices) p = (p - box.min) * scale;
  Result<MeshStock> made =
      stock_of_mesh(mesh, stock.pitch_mm, stock.room_mm.value_or(0.1 * longest * scale),
                    stock.material, options.threads, options.force);
  if (!made) return Error{name + made.error()};
  const std::string warning = made.value().warning();
  if (!warning.empty() && options.warning) options.warning(file + ": " + warning);
  if (made.value().model->empty()) return Error{kNothing};
  return std::move(made.value().model);
}

Made make(const StockMesh& shape, const Stock& stock, const StockOptions& options) {
  std::vector<std::string> notes;
  Result<TriangleMesh> mesh = read_mesh(shape.file, &notes);
  if (!mesh) return Error{"mesh " + mesh.error()};
  if (options.warning)
    for (const std::string& note : notes) options.warning(note);
  const Mat3 turn = rotation(shape.orientation);
  for (Vec3& p : mesh.value().vertices) p = turn * p;
  const std::string file = shape.file.string();
  return make_of(std::move(mesh).value(), shape.fit_mm, "mesh " + file + ": ", file, stock,
                 options);
}

Made make(const StockRelief& shape, const Stock& stock, const StockOptions& options) {
  Result<TriangleMesh> mesh = read_relief(shape.file, shape.size, stock.pitch_mm);
  if (!mesh) return Error{"relief " + mesh.error()};
  const std::string file = shape.file.string();
  return make_of(std::move(mesh).value(), std::nullopt, "relief " + file + ": ", file, stock,
                 options);
}

// The voxels of a label get the label's material.
Made make(const StockVolume& shape, const Stock& stock, const StockOptions& options) {
  const Result<LabelVolume> read = read_volume(shape.file);
  if (!read) return Error{"volume " + read.error()};
  const LabelVolume& volume = read.value();
  const std::vector<uint16_t> labels = labels_of(volume);
  if (labels.empty())
    return Error{"volume " + shape.file.string() +
                 ": has no label above 0, so it contains only air; check the file"};
  for (const uint16_t label : labels) {
    if (shape.labels.contains(label)) continue;
    const auto name = volume.names.find(label);
    return Error{"labels has no material for label " + std::to_string(label) +
                 (name == volume.names.end() ? "" : " (" + name->second + ")") +
                 "; add it, as in labels = { " + std::to_string(label) + " = \"oak\" }"};
  }
  return stock_of_labels(volume, shape.labels, stock.pitch_mm, stock.room_mm, options.threads);
}

std::string at_line(const std::string& file, int line) {
  return line > 0 ? file + ":" + std::to_string(line) : file;
}

}  // namespace

Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options) {
  Made made =
      std::visit([&](const auto& shape) { return make(shape, stock, options); }, stock.shape);
  // The message names a line only if the stock comes from a scene, not from the studio or Python.
  if (!made)
    return Error{at_line(scene_file, stock.line) + (stock.line > 0 ? ": [stock] " : ": ") +
                 made.error()};
  TriDexel& model = *made.value();
  EditOptions edit;
  edit.threads = options.threads;
  for (const StockLayer& layer : stock.layers) {
    const SweptTool shape(layer.shape, layer.pose, Vec3::Zero(), model.lattice());
    if (!change_material(model, shape.solid(), layer.material, edit))
      return Error{at_line(scene_file, layer.line) +
                   ": [layer] contains no material of the stock; move it, or make it larger"};
  }
  return made;
}

}  // namespace kibori
