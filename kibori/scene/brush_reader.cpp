// SPDX-License-Identifier: MIT
// Reads the brush of a move that reshapes.
#include <kibori/scene/scene_reader.h>

#include <kibori/motion/reshape_stroke.h>

namespace kibori {
namespace {

// Reads the plane to which a brush flattens the surface.
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

// Reads the file of a user's own texture.
void read_texture(SceneReader& reader, const TableReader& t, Brush& brush) {
  if (!t.has("texture")) return;
  if (t.has("alpha"))
    return t.fail("texture", "[brush] has both texture, a PNG file, and alpha; remove one of them");
  const std::filesystem::path path = reader.file(t, "texture");
  if (path.empty()) return;
  auto picture = read_alpha_picture(path);
  if (!picture) return t.fail("texture", picture.error());
  brush.alpha = Alpha::picture;
  brush.picture = std::move(picture).value();
}

}  // namespace

void read_brush(SceneReader& reader, const TableReader& move, Move& of) {
  static const toml::table kNone;
  const std::optional<TableReader> given = move.table("brush", "brush = { radius = 4 }");
  if (move.has("brush") && !given) return;
  const TableReader t = given.value_or(TableReader(move.error(), kNone, "brush"));
  Brush& brush = of.brush;
  // Scenes have no key `flatten_to`. It follows from `plane`. `texture` gives a picture for `alpha`.
  std::vector<std::string> keys = TableReader::keys_of<Brush>();
  std::erase(keys, "flatten_to");
  keys.emplace_back("texture");
  t.only(keys);
  // Until a move sets a strength, each move uses the default of its mode.
  reader.brush_has_strength |= t.has("strength");
  if (!reader.brush_has_strength) brush.strength = default_strength(of.mode);
  t.fields(brush);
  read_plane(t, brush);
  read_texture(reader, t, brush);
  if (t.failed()) return;
  const Status fine = reshapes(of.mode) ? check_brush_of(of.mode, brush) : check_brush(brush, true);
  if (!fine) move.fail("brush", "[brush] " + fine.error());
}

}  // namespace kibori
