// SPDX-License-Identifier: MIT
// The stock: its description, and the model that is made of it. Except for blocks, the memory for
// the model is checked before the model is made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/edit/scan_convert.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/geometry/mesh.h>
#include <kibori/geometry/orientation.h>
#include <kibori/scene/relief.h>
#include <kibori/solid/solid.h>
#include <kibori/solid/tool.h>

namespace kibori {

// A layer: another material for the part of the stock within a tool's shape, for example dentine
// within enamel. Where layers overlap, the last one counts.
struct StockLayer {
  Tool shape;
  Pose pose;
  uint8_t material = 0;
  int line = 0;  // line in the file
};

inline constexpr size_t kMaxLayers = 64;

// The shapes of a stock. The lower corner of a shape's bounds is at the origin.
struct StockBlock {
  static constexpr const char* kKind = "block";
  Vec3 size_mm = Vec3::Zero();
};
struct StockSphere {
  static constexpr const char* kKind = "sphere";
  double diameter_mm = 0;
};
struct StockCylinder {  // parallel to z
  static constexpr const char* kKind = "cylinder";
  double diameter_mm = 0, height_mm = 0;
};
struct StockMesh {
  static constexpr const char* kKind = "mesh";
  std::filesystem::path file = {};
  std::optional<double> fit_mm = {};  // length of the longest side after scaling
  Orientation orientation = {};       // axes of the file that become z and -y
};
struct StockRelief {  // from a picture
  static constexpr const char* kKind = "relief";
  std::filesystem::path file = {};
  ReliefSize size = {};
};
struct StockVolume {  // from a volume with labels
  static constexpr const char* kKind = "volume";
  std::filesystem::path file = {};
  std::map<uint16_t, uint8_t> labels = {};  // the material of each label
};
using StockShape =
    std::variant<StockBlock, StockSphere, StockCylinder, StockMesh, StockRelief, StockVolume>;

struct Stock {
  StockShape shape;
  double pitch_mm = 0;
  std::optional<double> room_mm;  // space around the stock; nullopt: 0.1 of the longest side
  uint8_t material = 0;
  std::vector<StockLayer> layers;
  std::optional<LogCut> log;  // the log that contains the stock; nullopt: as the material says
  int line = 0;               // line in the file
};

// Returns the size of a block, sphere or cylinder. Returns zero for a shape from a file.
Vec3 size_mm(const StockShape& shape);
// Return the file of the stock, or null if it has none.
const std::filesystem::path* file_of(const Stock& stock);
std::filesystem::path* file_of(Stock& stock);

struct StockOptions {
  int threads = 1;     // do not change the result
  bool force = false;  // accept a mesh even if more than half of its rays are open
  std::function<void(const std::string&)> warning = nullptr;  // gets one sentence per warning
};

// Makes the model of a stock. `scene_file` is its name in messages. Errors: the stock is
// impossible; a file cannot be read; there is too little memory; a layer contains no material.
Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options);

// Returns Ok if there is memory for a model of this lattice. If `mesh` is true, the memory of scan
// conversion is added. Otherwise, returns an error sentence with the needed memory and a pitch that
// fits.
Status check_memory(const Lattice& lattice, bool mesh);

struct MeshStock {
  std::unique_ptr<TriDexel> model;
  ScanReport report;
  std::string repairs;  // repairs by repair_mesh as a sentence; empty: none
  // Returns the repairs by repair_mesh and by scan_convert. Empty if there were none.
  std::string warning() const;
};

// Repairs a mesh (repair_mesh) and makes a model of it. The model has the coordinates of the mesh,
// and room_mm of space around it. Errors: those of make_lattice, check_memory and scan_convert; the
// mesh is too far from the origin.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force);
// Like above, on a given lattice. The lattice must contain the mesh.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, const Lattice& lattice, uint8_t material,
                                int threads, bool force);

// Makes a model of a labelled volume, with its lower corner at the origin. `materials` has the
// material of each label. The volume must have at least one label above 0. Errors: those of
// make_lattice and check_memory; there is no material at this pitch.
Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads);

// Gives the part of the model within a solid another material. The surface of the model does not
// change by a bit. Returns false if there is no material within the solid.
bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit);

}  // namespace kibori
