// SPDX-License-Identifier: MIT
// Reads a scene's mesh tool: a mesh file, letters, or a picture.
#include <kibori/scene/scene_reader.h>

#include <memory>

#include <kibori/formats/mesh_file.h>
#include <kibori/scene/stamp.h>

namespace kibori {
namespace {

// Reports an error for a key that does not apply to the tool's source.
void check_keys(const TableReader& t) {
  const auto belongs_to = [&](const char* key, const char* what) {
    if (t.has(key) && !t.has(what)) t.fail(key, t.full(key) + " needs " + what);
  };
  belongs_to("font", "text");
  belongs_to("size", "text");
  belongs_to("invert", "picture");
  if (t.has("width") && t.has("text"))
    t.fail("width", t.full("width does not apply to text; set size"));
  if (t.has("depth") && t.has("file"))
    t.fail("depth", t.full("depth does not apply to a mesh file; scale it with width"));
}

void read_size(const TableReader& t, const char* key, double& value) {
  if (t.has(key)) value = t.positive(key);
}

Result<Tool> read_letters(SceneReader& reader, const TableReader& t) {
  Lettering letters;
  letters.text = t.text("text");
  if (t.has("font")) letters.font = t.text("font");
  // A font file is a file of the scene: its path is relative to the scene's folder, and the scene
  // must be allowed to name files.
  if (letters.font.find('/') != std::string::npos) letters.font = reader.file(t, "font").string();
  if (t.failed()) return Error{""};
  read_size(t, "size", letters.height_mm);
  read_size(t, "depth", letters.depth_mm);
  return text_stamp(letters, reader.scene.stock.pitch_mm);
}

Result<Tool> read_picture(SceneReader& reader, const TableReader& t) {
  const std::filesystem::path path = reader.file(t, "picture");
  PictureStamp size;
  read_size(t, "width", size.width_mm);
  read_size(t, "depth", size.depth_mm);
  size.invert = t.flag_or("invert", false);
  if (path.empty()) return Error{""};
  return picture_stamp(path, size, reader.scene.stock.pitch_mm);
}

Result<Tool> read_mesh_tool(SceneReader& reader, const TableReader& t) {
  const std::filesystem::path path = reader.file(t, "file");
  if (path.empty()) return Error{""};
  if (t.has("width")) return mesh_stamp(path, t.positive("width"));
  Result<TriangleMesh> mesh = read_mesh(path);
  if (!mesh) return Error{mesh.error()};
  return Tool(MeshTool{std::make_shared<TriangleMesh>(std::move(mesh).value())});
}

}  // namespace

const std::vector<std::string>& stamp_keys() {
  static const std::vector<std::string> keys{"file", "text",  "picture", "font",
                                             "size", "width", "depth",   "invert"};
  return keys;
}

Tool read_stamp(SceneReader& reader, const TableReader& t) {
  const int kinds = int{t.has("file")} + t.has("text") + t.has("picture");
  if (kinds != 1) {
    t.fail(t.full("a mesh needs exactly one of file, text and picture"));
    return MeshTool{};
  }
  check_keys(t);
  if (t.failed()) return MeshTool{};
  const char* const what = t.has("text") ? "text" : t.has("picture") ? "picture" : "file";
  Result<Tool> made = t.has("text")      ? read_letters(reader, t)
                      : t.has("picture") ? read_picture(reader, t)
                                         : read_mesh_tool(reader, t);
  if (made) return std::move(made).value();
  t.fail(what, made.error());  // has no effect if a key has failed before
  return MeshTool{};
}

}  // namespace kibori
