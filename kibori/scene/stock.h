// SPDX-License-Identifier: MIT
// Stock to carve: what is said of it, and the model that it becomes, with memory looked at first.
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

// What of a stock lies within a tool's shape that stands so is of another material, as dentine lies
// within enamel. Later ones lie within, or over, earlier ones.
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
  Orientation orientation = {};       // how it stands
};
struct StockRelief {  // of a picture
  static constexpr const char* kKind = "relief";
  std::filesystem::path file = {};
  ReliefSize size = {};
};
struct StockVolume {  // of labels
  static constexpr const char* kKind = "volume";
  std::filesystem::path file = {};
  std::map<uint16_t, uint8_t> labels = {};  // the material of each
};
using StockShape =
    std::variant<StockBlock, StockSphere, StockCylinder, StockMesh, StockRelief, StockVolume>;

struct Stock {
  StockShape shape;
  double pitch_mm = 0;
  std::optional<double> room_mm;  // space around the stock
  uint8_t material = 0;
  std::vector<StockLayer> layers;
  int line = 0;  // in the file
};

// Of what is no file; 0 of what is.
Vec3 size_mm(const StockShape& shape);
// The file that it is made of; null: none.
const std::filesystem::path* file_of(const Stock& stock);
std::filesystem::path* file_of(Stock& stock);

struct StockOptions {
  int threads = 1;     // results do not depend on it
  bool force = false;  // accept a mesh whose rays mostly disagree
  std::function<void(const std::string&)> warning = nullptr;  // one sentence each
};

// The model of a stock. `scene_file`: for messages. Errors: what the stock can't be, a file that
// can't be read, more memory than there is.
Result<std::unique_ptr<TriDexel>> make_stock(const Stock& stock, const std::string& scene_file,
                                             const StockOptions& options);

// Ok, or one sentence saying how much memory a model of this lattice can take and which pitch would
// fit. mesh: scan conversion takes its share.
Status check_memory(const Lattice& lattice, bool mesh);

struct MeshStock {
  std::unique_ptr<TriDexel> model;
  ScanReport report;
};

// The mesh as a model, in its own coordinates, with room_mm of space around it. Errors: those of
// make_lattice, check_memory and scan_convert.
Result<MeshStock> stock_of_mesh(const TriangleMesh& mesh, double pitch_mm, double room_mm,
                                uint8_t material, int threads, bool force);

// A labelled volume, its lower corner at the origin: the voxels of each label are of the material
// that `materials` says, which must name all that the volume has; there must be some. Errors: those
// of make_lattice and check_memory; nothing is there at this pitch.
Result<std::unique_ptr<TriDexel>> stock_of_labels(const LabelVolume& volume,
                                                  const std::map<uint16_t, uint8_t>& materials,
                                                  double pitch_mm, std::optional<double> room_mm,
                                                  int threads);

// What the model has within a solid becomes of another material, its faces bit for bit as they
// were. False: it has nothing there.
bool change_material(TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& edit);

}  // namespace kibori
