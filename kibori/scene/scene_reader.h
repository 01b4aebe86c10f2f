// SPDX-License-Identifier: MIT
// Reads a scene: the shared state, and one reader for each group of tables, in the order in which
// they run. Internal: not installed.
#pragma once

#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>

#include <kibori/scene/scene.h>
#include <kibori/scene/table_reader.h>

namespace kibori {

inline constexpr double kRadPerDeg = std::numbers::pi / 180;

// Call it before toml++. The parser, and the destructor of its result, recurse as deep as tables
// are nested. A dotted key is as deep as its number of dots. Error: one sentence with `name` and
// line.
Status check_toml_depth(std::string_view text, const std::string& name);

struct SceneReader {
  SceneReader(const std::string& name, std::optional<std::filesystem::path> files)
      : error(name), folder(std::move(files)) {
    scene.file = name;
  }

  // Path of the file that a key names; empty if the scene may not name files.
  std::filesystem::path file(const TableReader& t, std::string_view key);
  // The built-in material of that name, with the constants of [force] instead of its own.
  Material default_material(const std::string& name) const;
  // Returns its index.
  uint8_t add_material(int line, const Material& material);
  // Index of a material by name. The material is defined in the scene or built in.
  uint8_t material(int line, const std::string& name);
  uint8_t material(const TableReader& t, std::string_view key) {
    return material(t.line(key), t.text(key));
  }

  Scene scene;
  SceneError error;
  // folder of its files; none: the scene may not name files
  std::optional<std::filesystem::path> folder;
  std::optional<double> kf, u;      // of [force]
  bool brush_has_strength = false;  // a move has set the brush's strength
};

void read_force(SceneReader& reader, const TableReader& root);
void read_materials(SceneReader& reader, const TableReader& root);
void read_stock(SceneReader& reader, const TableReader& root);
void read_motion(SceneReader& reader, const TableReader& root);
void read_moves(SceneReader& reader, const TableReader& root);
void read_symmetry(SceneReader& reader, const TableReader& root);
// Reads crumbs, cutters, splines and protected bodies.
void read_bodies(SceneReader& reader, const TableReader& root);

// Reads a tool. A missing key keeps the value of `inherited`, if that has the same shape.
// `inherited` may be null.
Tool read_tool(SceneReader& reader, const TableReader& t, const Tool* inherited);
// Reads the mesh, letters or picture of a mesh tool's table. stamp_keys() lists the keys.
Tool read_stamp(SceneReader& reader, const TableReader& t);
const std::vector<std::string>& stamp_keys();
// Reads a shape in the stock, and its orientation.
Tool read_shape(SceneReader& reader, const TableReader& t);
Mat3 read_frame(const TableReader& t);
// Reads a move's brush. A missing key keeps the value of the previous move.
void read_brush(SceneReader& reader, const TableReader& move, Move& of);

}  // namespace kibori
