// SPDX-License-Identifier: MIT
// The functions that read a scene, one for each group of tables, in the order of their calls. They
// share the state SceneReader. Internal: not installed.
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

// Checks that tables and lists are not nested too deep. Each dot of a dotted key counts as a level.
// Call this before toml++, which recurses for each level, so that a deep file would overflow the
// stack. Errors: the nesting is too deep; the message has `name` and the line.
Status check_toml_depth(std::string_view text, const std::string& name);

struct SceneReader {
  SceneReader(const std::string& name, std::optional<std::filesystem::path> files)
      : error(name), folder(std::move(files)) {
    scene.file = name;
  }

  // Returns the path of the file that a key names. If the scene may not name files, reports an
  // error and returns an empty path.
  std::filesystem::path file(const TableReader& t, std::string_view key);
  // Returns the built-in material with this name. If there is none, returns a default material with
  // this name. The values of [force] (kf, u) replace those of the material.
  Material default_material(const std::string& name) const;
  // Adds a material and returns its index. Reports an error if there are too many.
  uint8_t add_material(int line, const Material& material);
  // Returns the index of the material with this name. If the scene does not define it, adds the
  // built-in material. Reports an error if there is none.
  uint8_t material(int line, const std::string& name);
  uint8_t material(const TableReader& t, std::string_view key) {
    return material(t.line(key), t.text(key));
  }

  Scene scene;
  SceneError error;
  // File names are relative to this folder. nullopt: the scene may not name files.
  std::optional<std::filesystem::path> folder;
  std::optional<double> kf, u;      // values of [force]
  bool brush_has_strength = false;  // true if a move so far sets the brush's strength
};

void read_force(SceneReader& reader, const TableReader& root);
void read_materials(SceneReader& reader, const TableReader& root);
void read_stock(SceneReader& reader, const TableReader& root);
void read_motion(SceneReader& reader, const TableReader& root);
void read_moves(SceneReader& reader, const TableReader& root);
void read_symmetry(SceneReader& reader, const TableReader& root);
// Reads crumbs, cutters, splines and protected bodies.
void read_bodies(SceneReader& reader, const TableReader& root);

// Reads a tool. If a key is missing, the value comes from the preset, or from `inherited` if it has
// the same shape. Otherwise, a missing key is an error. `inherited` may be null.
Tool read_tool(SceneReader& reader, const TableReader& t, const Tool* inherited);
// Reads a mesh tool from a mesh file, a text or a picture. stamp_keys() returns its keys.
Tool read_stamp(SceneReader& reader, const TableReader& t);
const std::vector<std::string>& stamp_keys();
// Reads a tool that gives a layer or a protected body its shape.
Tool read_shape(SceneReader& reader, const TableReader& t);
// Reads the orientation of this shape: `axis` and `roll_deg`.
Mat3 read_frame(const TableReader& t);
// Reads the brush of the move `of`. If a key is missing, the value is that of the previous move.
void read_brush(SceneReader& reader, const TableReader& move, Move& of);

}  // namespace kibori
