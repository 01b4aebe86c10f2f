// SPDX-License-Identifier: MIT
// The stock that is carved: its description, and the model that is made from it. Meshes, volumes
// and round shapes are checked first for enough memory.
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

// A layer: the part of the stock within a tool's shape gets another material. An example is dentine
// within enamel. Where layers overlap, the later one applies.
struct StockLayer {
  Tool shape;
  Pose pose;
  uint8_t material = 0;
  int line = 0;  // in the file
};

inline constexpr size_t kMaxLayers = 64;

// The shapes of a stock. The lower corner of their bounds is the origin.
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
  std::optional<double> fit_mm = {};  // length to which its longest side is scaled
  Orientation orientation = {};       // axes of the file that become z and -y
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
  std::optional<double> room_mm;  // space around the stock; nullopt: 0.1 of its longest side
  uint8_t material = 0;
  std::vector<StockLayer> layers;
  std::optional<LogCut> log;  // the log that it was cut from; nullopt: as the material defines
  int line = 0;               // in the file
};

// Size of a block, sphere or cylinder; zero for a shape that is read from a file.
Vec3 size_mm(const StockShape& shape);
// The file of the stock; null if it has none.
const std::filesystem::path* file_of(const Stock& stock);
std::filesystem::path* file_of(Stock& stock);

struct StockOptions {
  int threads = 1;     // results do not depend on it
  bool force = false;  // accept a mesh even if more than half of its rays are open
  std::function<void(const std::string&)> warning = nullptr;  // called with one sentence each
};

// Makes the model of a stock. `scene_file`: for messages. Errors: an impossible stock; a file that
// cannot be read; not enough memory; a layer that contains no material.
Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options);

// Checks that memory for a model of this lattice is available. `mesh`: adds the memory of scan
// conversion. Error: one sentence with the memory that is needed and a pitch that would fit.
Status check_memory(const Lattice& lattice, bool mesh);

struct MeshStock {
  std::unique_ptr<TriDexel> model;
  ScanReport report;
  std::string repairs;  // by repair_mesh, as one sentence; empty if there were none
  // The repairs of repair_mesh and of scan_convert; empty if there were none.
  std::string warning() const;
};

// Repairs the mesh (repair_mesh) and makes a model of it. The model has the mesh's coordinates, and
// room_mm of space around the mesh. Errors: those of make_lattice, check_memory and scan_convert; a
// mesh too far from the origin.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force);
// The same on a given lattice, which must contain the mesh.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, const Lattice& lattice, uint8_t material,
                                int threads, bool force);

// Makes a model of a labelled volume, with its lower corner at the origin. `materials` gives the
// material of each label. It must contain all labels of the volume, and the volume must have one.
// Errors: those of make_lattice and check_memory; no material at this pitch.
Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads);

// Gives the part of the model within a solid another material. The model's surface stays the same
// bit for bit. Returns false if the model has no material there.
bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit);

}  // namespace kibori
