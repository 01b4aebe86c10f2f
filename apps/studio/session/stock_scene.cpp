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
    return Error{"the studio cannot show this much detail; choose less"};
  if (!(longest_mm >= 8 * stock.pitch_mm))
    return Error{"this is too coarse to carve; choose more detail"};
  Scene scene;
  scene.file = "the new document";
  scene.stock = stock;
  scene.materials = known_materials();
  if (material >= scene.materials.size()) return Error{"this material is unknown"};
  scene.stock.material = static_cast<uint8_t>(material);
  if (const auto* volume = std::get_if<StockVolume>(&stock.shape);
      volume && !volume->labels.empty())
    scene.stock.material = volume->labels.begin()->second;
  share_log(scene.materials, scene.stock.material);
  scene.tools = {BallTool{4}};
  scene.moves = {Move{}};
  return scene;
}

}  // namespace

Result<Scene> stock_scene(const StockShape& shape, double pitch_mm, size_t material) {
  Stock stock;
  stock.shape = shape;
  stock.pitch_mm = pitch_mm;
  const Vec3 size = size_mm(shape);
  if (!(size.minCoeff() >= kMinMm)) return Error{kSize};
  return scene_of(stock, size.maxCoeff(), material);
}

Result<Scene> file_scene(const std::filesystem::path& file, const FileStock& how) {
  if (!(how.rays >= 8 && how.rays <= kMaxRays)) return Error{"the detail must be 8 to 1024 rays"};
  if (!(how.longest_mm >= kMinMm && how.longest_mm <= kMaxMm)) return Error{kSize};
  Stock stock;
  if (ending_of(file) == ".png") {
    const Result<GreyMap> picture = read_png_grey(file);
    if (!picture) return Error{picture.error()};
    for (const double height : {how.height_mm, how.base_mm})
      if (!(height >= kMinMm && height <= how.longest_mm))
        return Error{
            "the relief's height and base must be at least 0.1 mm, and no more than its longest "
            "side"};
    const double wide = picture.value().width, high = picture.value().height;
    stock.shape = StockRelief{
        file,
        {how.longest_mm * wide / std::max(wide, high), how.height_mm, how.base_mm, how.invert}};
  } else if (ending_of(file) == ".nrrd") {
    stock.shape = StockVolume{file, how.labels};
    for (const auto& [label, material] : how.labels)
      if (material >= known_materials().size()) return Error{"this material is unknown"};
  } else {
    stock.shape = StockMesh{file, how.longest_mm, how.orientation};
  }
  stock.pitch_mm = how.longest_mm / how.rays;
  return scene_of(stock, how.longest_mm, how.material);
}

Result<Tool> file_shape(const std::filesystem::path& file, const FileStock& how) {
  if (!(how.longest_mm >= kMinMm && how.longest_mm <= kMaxMm)) return Error{kSize};
  if (ending_of(file) == ".png") return Error{"a picture cannot become a body; choose a mesh"};
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
