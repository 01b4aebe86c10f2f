// SPDX-License-Identifier: MIT
// Reads the brush of a move that reshapes.
#include <kibori/scene/scene_reader.h>

#include <kibori/motion/reshape_stroke.h>

namespace kibori {
namespace {

// Reads the plane that a brush flattens to.
void read_plane(const TableReader& t, Brush& brush) {
  const toml::node* const node = t.find("plane");
  if (!node) return;
  const auto known = value_of<FlattenTo>(node->value_or(std::string()));
  if (node->is_table()) {
    const TableReader plane(t.error(), *node->as_table(), "plane");
    plane.only(TableReader::keys_of<FlatPlane>());
    brush.plane = {plane.vector("point"), plane.vector("normal")};
    brush.flatten_to = FlattenTo::plane;
  } else if (known && *known != FlattenTo::plane) {
    brush.flatten_to = *known;
  } else {
    t.fail("plane",
           "[brush] plane must be \"stroke\", \"dab\", or a table, as in plane = { point = [0, 0, "
           "5], normal = [0, 0, 1] }");
  }
}

}  // namespace

void read_brush(SceneReader& reader, const TableReader& move, Move& of) {
  static const toml::table kNone;
  const std::optional<TableReader> given = move.table("brush", "brush = { radius = 4 }");
  if (move.has("brush") && !given) return;
  const TableReader t = given.value_or(TableReader(move.error(), kNone, "brush"));
  Brush& brush = of.brush;
  // `plane` also gives flatten_to.
  std::vector<std::string> keys = TableReader::keys_of<Brush>();
  std::erase(keys, "flatten_to");
  t.only(keys);
  // If no move has set a strength, the mode's default is used.
  reader.brush_has_strength |= t.has("strength");
  if (!reader.brush_has_strength) brush.strength = default_strength(of.mode);
  t.fields(brush);
  read_plane(t, brush);
  const Status fine = reshapes(of.mode) ? check_brush_of(of.mode, brush) : check_brush(brush);
  if (!fine) move.fail("brush", "[brush] " + fine.error());
}

}  // namespace kibori
