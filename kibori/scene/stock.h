// SPDX-License-Identifier: MIT
// Stock to carve: its description, and the model made from it. Checks first that there is enough
// memory.
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

// A layer: the part of a stock within a tool's shape gets another material, as dentine within
// enamel. Later layers replace earlier ones.
struct StockLayer {
  Tool shape;
  Pose pose;
  uint8_t material = 0;
  int line = 0;  // in the file
};

inline constexpr size_t kMaxLayers = 64;

// The shapes of a stock; their bounds begin at the origin.
struct StockBlock {
  static constexpr const char* kKind = "block";
  Vec3 size_mm = Vec3::Zero();
};
struct StockSphere {
  static constexpr const char* kKind = "sphere";
  double diameter_mm = 0;
};
struct StockCylinder {  // upright
  static constexpr const char* kKind = "cylinder";
  double diameter_mm = 0, height_mm = 0;
};
struct StockMesh {
  static constexpr const char* kKind = "mesh";
  std::filesystem::path file = {};
  std::optional<double> fit_mm = {};  // scaled so that its longest side is this
  Orientation orientation = {};       // orientation of the mesh
};
struct StockRelief {  // of a picture
  static constexpr const char* kKind = "relief";
  std::filesystem::path file = {};
  ReliefSize size = {};
};
struct StockVolume {  // of labels
  static constexpr const char* kKind = "volume";
  std::filesystem::path file = {};
  std::map<uint16_t, uint8_t> labels = {};  // the material of each label
};
using StockShape =
    std::variant<StockBlock, StockSphere, StockCylinder, StockMesh, StockRelief, StockVolume>;

struct Stock {
  StockShape shape;
  double pitch_mm = 0;
  std::optional<double> room_mm;  // space around the stock
  uint8_t material = 0;
  std::vector<StockLayer> layers;
  std::optional<LogCut> log;  // how it was cut; null: as its material defines
  int line = 0;               // in the file
};

// Size of a shape that is not a file; 0 for files.
Vec3 size_mm(const StockShape& shape);
// The file of the stock; null if it has none.
const std::filesystem::path* file_of(const Stock& stock);
std::filesystem::path* file_of(Stock& stock);

struct StockOptions {
  int threads = 1;     // results do not depend on it
  bool force = false;  // accept a mesh even if many of its rays are open
  std::function<void(const std::string&)> warning = nullptr;  // called with one sentence each
};

// Makes the model of a stock. `scene_file`: for messages. Errors: an impossible stock; a file that
// cannot be read; not enough memory.
Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options);

// Returns Ok, or one sentence with the memory that a model of this lattice needs and a pitch that
// would fit. mesh: includes the memory of scan conversion.
Status check_memory(const Lattice& lattice, bool mesh);

struct MeshStock {
  std::unique_ptr<TriDexel> model;
  ScanReport report;
  std::string repairs;  // repair_mesh: one sentence; empty if there were none
  // All repairs; empty if there were none.
  std::string warning() const;
};

// Makes a model of the mesh after repair_mesh, in its own coordinates, with room_mm of space around
// it. Errors: those of make_lattice, check_memory and scan_convert.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force);
// The same on a lattice that holds the mesh.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, const Lattice& lattice, uint8_t material,
                                int threads, bool force);

// Makes a model of a labelled volume, with its lower corner at the origin. `materials` gives the
// material of each label. It must contain all labels of the volume and must not be empty. Errors:
// those of make_lattice and check_memory; no material at this pitch.
Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads);

// Changes the material of what the model has within a solid. The faces stay the same bit for bit.
// Returns false if the model has nothing there.
bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit);

}  // namespace kibori
