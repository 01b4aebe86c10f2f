// SPDX-License-Identifier: MIT
// Declares the functions that read a scene, one for each group of tables. They are listed in the
// order of their calls. SceneReader is the state that they share. Internal: not installed.
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

// Checks that tables and lists are not nested too deep. Call it before toml++. The parser of toml++
// and the destructor of its result recurse for each level, so a deep file would overflow the stack.
// Each dot of a dotted key counts as a level. Error: one sentence with `name` and line.
Status check_toml_depth(std::string_view text, const std::string& name);

struct SceneReader {
  SceneReader(const std::string& name, std::optional<std::filesystem::path> files)
      : error(name), folder(std::move(files)) {
    scene.file = name;
  }

  // Path of the file that a key names; empty if the scene may not name files.
  std::filesystem::path file(const TableReader& t, std::string_view key);
  // The built-in material of that name, or a default one with that name. Constants that [force]
  // gives replace its own.
  Material default_material(const std::string& name) const;
  // Adds a material and returns its index. Reports an error if there are too many.
  uint8_t add_material(int line, const Material& material);
  // Index of the material with this name. Adds a built-in material if the scene does not define it.
  uint8_t material(int line, const std::string& name);
  uint8_t material(const TableReader& t, std::string_view key) {
    return material(t.line(key), t.text(key));
  }

  Scene scene;
  SceneError error;
  // File names are relative to this folder. nullopt: the scene may not name files.
  std::optional<std::filesystem::path> folder;
  std::optional<double> kf, u;      // of [force]
  bool brush_has_strength = false;  // true if a move so far has set the brush's strength
};

void read_force(SceneReader& reader, const TableReader& root);
void read_materials(SceneReader& reader, const TableReader& root);
void read_stock(SceneReader& reader, const TableReader& root);
void read_motion(SceneReader& reader, const TableReader& root);
void read_moves(SceneReader& reader, const TableReader& root);
void read_symmetry(SceneReader& reader, const TableReader& root);
// Reads crumbs, cutters, splines and protected bodies.
void read_bodies(SceneReader& reader, const TableReader& root);

// Reads a tool. A missing key keeps the value of the preset or else of `inherited`, if that has the
// same shape. Otherwise it is an error. `inherited` may be null.
Tool read_tool(SceneReader& reader, const TableReader& t, const Tool* inherited);
// Reads a mesh tool from a mesh file, a text or a picture. stamp_keys() lists its keys.
Tool read_stamp(SceneReader& reader, const TableReader& t);
const std::vector<std::string>& stamp_keys();
// Reads the tool that is the shape of a layer or of a protected body.
Tool read_shape(SceneReader& reader, const TableReader& t);
// Reads the orientation of such a shape: `axis` and `roll_deg`.
Mat3 read_frame(const TableReader& t);
// Reads the brush of the move `of`. A missing key keeps the value of the previous move.
void read_brush(SceneReader& reader, const TableReader& move, Move& of);

}  // namespace kibori
