// SPDX-License-Identifier: MIT
#include "apps/studio/session/stock_scene.h"

#include <algorithm>
#include <memory>

#include <kibori/base/file.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/haptics/materials.h>

namespace kibori {
namespace {

constexpr double kMinMm = 0.1, kMaxMm = 10000;
constexpr const char* kSize = "the size must be 0.1 to 10000 mm";

Result<Scene> scene_of(const Stock& stock, double longest_mm, size_t material) {
  if (!(longest_mm >= kMinMm && longest_mm <= kMaxMm)) return Error{kSize};
  if (!(stock.pitch_mm > 0) || !(longest_mm <= kMaxRays * stock.pitch_mm))
    return Error{"that is finer than can be shown; choose less detail"};
  if (!(longest_mm >= 8 * stock.pitch_mm)) return Error{"that is too coarse; choose more detail"};
  Scene scene;
  scene.file = "the new document";
  scene.stock = stock;
  scene.materials = known_materials();
  if (material >= scene.materials.size()) return Error{"there is no such material"};
  scene.stock.material =
      stock.labels.empty() ? static_cast<uint8_t>(material) : stock.labels.begin()->second;
  scene.tools = {BallTool{4}};
  scene.moves = {Move{}};
  return scene;
}

}  // namespace

Result<Scene> stock_scene(Stock::Kind kind, const Vec3& size_mm, double pitch_mm, size_t material) {
  Stock stock;
  stock.kind = kind;
  stock.size_mm = size_mm;
  if (kind == Stock::Kind::cylinder) stock.size_mm.y() = size_mm.x();
  if (kind == Stock::Kind::sphere) stock.size_mm = Vec3::Constant(size_mm.x());
  stock.pitch_mm = pitch_mm;
  if (!(stock.size_mm.minCoeff() >= kMinMm)) return Error{kSize};
  return scene_of(stock, stock.size_mm.maxCoeff(), material);
}

Result<Scene> file_scene(const std::filesystem::path& file, const FileStock& how) {
  if (!(how.rays >= 8 && how.rays <= kMaxRays)) return Error{"the detail must be 8 to 1024 rays"};
  if (!(how.longest_mm >= kMinMm && how.longest_mm <= kMaxMm)) return Error{kSize};
  Stock stock;
  stock.mesh_path = file;
  if (ending_of(file) == ".png") {
    const Result<GreyMap> picture = read_png_grey(file);
    if (!picture) return Error{picture.error()};
    for (const double height : {how.height_mm, how.base_mm})
      if (!(height >= kMinMm && height <= how.longest_mm))
        return Error{
            "the relief's height and base must be at least 0.1 mm, and no more than its longest "
            "side"};
    stock.kind = Stock::Kind::relief;
    const double wide = picture.value().width, high = picture.value().height;
    stock.width_mm = how.longest_mm * wide / std::max(wide, high);
    stock.height_mm = how.height_mm;
    stock.base_mm = how.base_mm;
    stock.invert = how.invert;
  } else if (ending_of(file) == ".nrrd") {
    stock.kind = Stock::Kind::volume;
    stock.labels = how.labels;
    for (const auto& [label, material] : how.labels)
      if (material >= known_materials().size()) return Error{"there is no such material"};
  } else {
    stock.kind = Stock::Kind::mesh;
    stock.fit_mm = how.longest_mm;
    stock.orientation = how.orientation;
  }
  stock.pitch_mm = how.longest_mm / how.rays;
  return scene_of(stock, how.longest_mm, how.material);
}

Result<Tool> file_shape(const std::filesystem::path& file, const FileStock& how) {
  if (!(how.longest_mm >= kMinMm && how.longest_mm <= kMaxMm)) return Error{kSize};
  if (ending_of(file) == ".png") return Error{"a picture is no body; bring a mesh"};
  Result<TriangleMesh> read = read_mesh(file);
  if (!read) return Error{read.error()};
  const auto mesh = std::make_shared<TriangleMesh>(std::move(read).value());
  const Mat3 turn = rotation(how.orientation);
  for (Vec3& p : mesh->vertices) p = turn * p;
  const Box box = mesh->bounds();
  const double longest = box.size().maxCoeff();
  if (!(longest > 0)) return Error{"the mesh has no extent"};
  for (Vec3& p : mesh->vertices) p = (p - box.centre()) * (how.longest_mm / longest);
  return Tool(MeshTool{mesh});
}

}  // namespace kibori
