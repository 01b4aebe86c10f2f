// SPDX-License-Identifier: MIT
// Reading a scene: what all readers share, and one reader for each group of tables, in the order in
// which they run. Internal: not installed.
#pragma once

#include <filesystem>
#include <numbers>
#include <optional>
#include <string>

#include <kibori/scene/scene.h>
#include <kibori/scene/table_reader.h>

namespace kibori {

inline constexpr double kRadPerDeg = std::numbers::pi / 180;

struct SceneReader {
  SceneReader(const std::string& name, std::optional<std::filesystem::path> files)
      : error(name), folder(std::move(files)) {
    scene.file = name;
  }

  // The file that a key names; empty where there may be none.
  std::filesystem::path file(const TableReader& t, std::string_view key);
  // A material by that name as the program knows it, with [force]'s constants in place of its own.
  Material default_material(const std::string& name) const;
  // Its index.
  uint8_t add_material(int line, const Material& material);
  // The index of a material by name, defined in the scene or known to the program.
  uint8_t material(int line, const std::string& name);
  uint8_t material(const TableReader& t, std::string_view key) {
    return material(t.line(key), t.text(key));
  }

  Scene scene;
  SceneError error;
  std::optional<std::filesystem::path> folder;  // where its files are; none: it may name none
  std::optional<double> kf, u;                  // of [force]
  bool brush_has_strength = false;              // a move has said a brush's strength
};

void read_force(SceneReader& reader, const TableReader& root);
void read_materials(SceneReader& reader, const TableReader& root);
void read_stock(SceneReader& reader, const TableReader& root);
void read_motion(SceneReader& reader, const TableReader& root);
void read_moves(SceneReader& reader, const TableReader& root);
void read_symmetry(SceneReader& reader, const TableReader& root);
// Crumbs, cutters, splines, and what no move may cut.
void read_bodies(SceneReader& reader, const TableReader& root);

// A tool. Keys left out keep the value of `inherited`, if that has the same shape; may be null.
Tool read_tool(SceneReader& reader, const TableReader& t, const Tool* inherited);
// The mesh, letters or picture that a mesh tool's table names, and the keys that say so.
Tool read_stamp(SceneReader& reader, const TableReader& t);
const std::vector<std::string>& stamp_keys();
// A shape that stands in the stock: which, and how it stands.
Tool read_shape(SceneReader& reader, const TableReader& t);
Mat3 read_frame(const TableReader& t);
// A move's brush: keys left out keep their value of the move before.
void read_brush(SceneReader& reader, const TableReader& move, Move& of);

}  // namespace kibori
