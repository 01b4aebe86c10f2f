// SPDX-License-Identifier: MIT
// The stocks that a Model can begin with.
#include <kibori/scene/stock.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/geometry/label_volume.h>

#include "python/src/materials.h"
#include "python/src/model.h"
#include "python/src/tools.h"

namespace kibori::python {
namespace {

Shared shared(Result<std::unique_ptr<Workpiece>> piece) {
  return std::make_shared<Model>(value_of(std::move(piece)));
}

Shared make_stock_of(Stock stock, const MaterialOrName& material, int threads) {
  const std::vector<Material> materials{material_named(material)};
  const py::gil_scoped_release no_gil;
  return shared(Workpiece::make(stock, materials, threads));
}

Shared block(const Three& size, double pitch, const MaterialOrName& material,
             const std::optional<double>& room, int threads) {
  Stock stock;
  stock.shape = StockBlock{vec(size)};
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared sphere(double diameter, double pitch, const MaterialOrName& material,
              const std::optional<double>& room, int threads) {
  Stock stock;
  stock.shape = StockSphere{diameter};
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared cylinder(double diameter, double height, double pitch, const MaterialOrName& material,
                const std::optional<double>& room, int threads) {
  Stock stock;
  stock.shape = StockCylinder{diameter, height};
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared mesh_file(const std::filesystem::path& path, double pitch, const MaterialOrName& material,
                 const std::optional<double>& fit, const std::optional<double>& room, int threads) {
  Stock stock;
  stock.shape = StockMesh{path, fit};
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared mesh_arrays(const Doubles& vertices, const py::object& triangles, double pitch,
                   const MaterialOrName& material, const std::optional<double>& room, int threads) {
  const TriangleMesh mesh = mesh_of(vertices, triangles);
  const std::vector<Material> materials{material_named(material)};
  const py::gil_scoped_release no_gil;
  const double room_mm = room.value_or(0.1 * mesh.bounds().size().maxCoeff());
  MeshStock made = value_of(stock_of_mesh(mesh, pitch, room_mm, 0, threads, false));
  if (!(made.model->volume_mm3() > 0))
    throw Failure("the mesh contains no material at this pitch; use a finer pitch");
  return shared(Workpiece::of(std::move(made.model), materials));
}

// Makes a model from an array of labels [x, y, z]. 0 is air.
Shared volume(const py::object& given_volume, const Three& voxel, double pitch,
              const std::map<uint16_t, MaterialOrName>& of, const std::optional<double>& room,
              int threads) {
  const auto given_labels = py::array::ensure(given_volume);
  const char kind = given_labels ? given_labels.dtype().kind() : ' ';
  if (!given_labels || given_labels.ndim() != 3 || (kind != 'b' && kind != 'u' && kind != 'i'))
    throw py::value_error("a volume must be an array of labels [x, y, z]: whole numbers, 0 is air");
  const auto labels =
      py::array_t<int64_t, py::array::c_style | py::array::forcecast>::ensure(given_labels);
  if (!labels) throw py::error_already_set();
  LabelVolume volume;
  volume.voxel_mm = vec(voxel);
  for (int i = 0; i < 3; i++) {
    const py::ssize_t size = labels.shape(i);
    if (size < 1 || size > 2048)
      throw Failure("a volume must have 1 to 2048 voxels along each axis");
    volume.size[i] = static_cast<int>(size);
    if (!(volume.voxel_mm[i] > 0) || !(volume.voxel_mm[i] < 1e6))
      throw Failure("the sides of voxels must be longer than 0 mm");
  }
  const auto at = labels.unchecked<3>();
  volume.values.reserve(static_cast<size_t>(labels.size()));
  for (int z = 0; z < volume.size.z(); z++)
    for (int y = 0; y < volume.size.y(); y++)
      for (int x = 0; x < volume.size.x(); x++) {
        if (at(x, y, z) < 0 || at(x, y, z) > 65535) throw Failure("labels must be 0 to 65535");
        volume.values.push_back(static_cast<uint16_t>(at(x, y, z)));
      }
  const std::vector<uint16_t> known = labels_of(volume);
  if (known.empty()) throw Failure("the volume contains only air");
  std::vector<Material> materials;
  for (const uint16_t label : known) {
    const auto material = of.find(label);
    if (material == of.end() && !of.empty())
      throw Failure("materials has no entry for label " + std::to_string(label) + "");
    materials.push_back(material == of.end() ? material_named(std::string("limewood"))
                                             : material_named(material->second));
  }
  if (materials.size() > kMaxMaterials)
    throw Failure("a piece has at most " + std::to_string(kMaxMaterials) + " materials");
  std::map<uint16_t, uint8_t> numbers;
  for (size_t i = 0; i < known.size(); i++) numbers[known[i]] = static_cast<uint8_t>(i);
  const py::gil_scoped_release no_gil;
  return shared(
      Workpiece::of(value_of(stock_of_labels(volume, numbers, pitch, room, threads)), materials));
}

}  // namespace

void bind_stocks(ModelClass& model) {
  const MaterialOrName lime = std::string("limewood");
  model
      .def_static("block", &block, py::arg("size"), py::arg("pitch"), py::arg("material") = lime,
                  py::kw_only(), py::arg("room") = py::none(), py::arg("threads") = 1,
                  "A block from the origin to size [mm]. pitch: distance between two rays [mm]. "
                  "room: space around it [mm]; default: a tenth of its longest side.")
      .def_static("sphere", &sphere, py::arg("diameter"), py::arg("pitch"),
                  py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
                  py::arg("threads") = 1, "A ball whose bounds begin at the origin.")
      .def_static("cylinder", &cylinder, py::arg("diameter"), py::arg("height"), py::arg("pitch"),
                  py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
                  py::arg("threads") = 1, "An upright cylinder whose bounds begin at the origin.")
      .def_static("mesh", &mesh_file, py::arg("path"), py::arg("pitch"), py::arg("material") = lime,
                  py::kw_only(), py::arg("fit") = py::none(), py::arg("room") = py::none(),
                  py::arg("threads") = 1,
                  ("A mesh file (" + list_of(kMeshesRead) +
                   ") in mm, moved so that its bounds begin at the origin. fit: longest side of "
                   "the scaled mesh [mm].")
                      .c_str())
      .def_static("mesh", &mesh_arrays, py::arg("vertices"), py::arg("triangles"), py::arg("pitch"),
                  py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
                  py::arg("threads") = 1,
                  "A mesh from arrays, not moved: vertices [N, 3] in mm, triangles [M, 3] of whole "
                  "numbers, counterclockwise seen from outside.")
      .def_static("volume", &volume, py::arg("labels"), py::arg("voxel"), py::arg("pitch"),
                  py::arg("materials") = std::map<uint16_t, MaterialOrName>(), py::kw_only(),
                  py::arg("room") = py::none(), py::arg("threads") = 1,
                  "Labelled voxels [x, y, z], 0 is air. voxel: their sides [mm]. materials: the "
                  "material of each label. Smooth surfaces between voxels bound the labels. Parts "
                  "thinner than three voxels lose volume.")
      .def_static(
          "open",
          [](const std::filesystem::path& path) {
            const py::gil_scoped_release no_gil;
            return shared(Workpiece::open(path));
          },
          py::arg("path"),
          "The model at the head of a .kibori document. The file does not change.");
}

}  // namespace kibori::python
