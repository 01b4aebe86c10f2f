// SPDX-License-Identifier: MIT
// Reads [stock] and [[layer]] of a scene.
#include <kibori/scene/scene_reader.h>

#include <charconv>

namespace kibori {
namespace {

// Reads the material of each label: labels = { 1 = "enamel", 2 = "dentine" }.
void read_labels(SceneReader& reader, const TableReader& t,
                 std::map<uint16_t, uint8_t>& materials) {
  const toml::node* node = t.find("labels");
  const toml::table* labels = node ? node->as_table() : nullptr;
  if (!labels || labels->empty())
    return t.fail("labels",
                  "[stock] volume needs the material of each label, as in labels = { 1 = \"oak\", "
                  "2 = \"pine\" }");
  for (const auto& [key, value] : *labels) {
    const std::string label(key.str());
    const auto name = value.value_exact<std::string>();
    int number = 0;
    const auto [end, error] = std::from_chars(label.data(), label.data() + label.size(), number);
    if (error != std::errc() || end != label.data() + label.size() || number < 1 || number > 65535)
      return t.fail("labels", "[stock] labels are numbers from 1 to 65535, not \"" + label + "\"");
    if (!name) return t.fail("labels", "[stock] label " + label + " must be a material's name");
    materials[static_cast<uint16_t>(number)] = reader.material(t.line("labels"), *name);
  }
}

StockShape read_kind(SceneReader& reader, const TableReader& t) {
  int kinds = 0;
  for (const char* kind : {"block", "mesh", "sphere", "cylinder", "relief", "volume"})
    kinds += t.has(kind) ? 1 : 0;
  if (kinds != 1)
    t.fail("[stock] needs exactly one of block, mesh, sphere, cylinder, relief and volume");
  if (t.has("block")) {
    const Vec3 size = t.vector("block");
    if (!(size.array() > 0).all()) t.fail("block", "[stock] block must have three positive sides");
    return StockBlock{size};
  }
  if (t.has("sphere")) return StockSphere{2 * t.positive("sphere")};
  if (t.has("cylinder")) {
    const auto v = t.numbers("cylinder", 2);
    if (!(v[0] > 0 && v[1] > 0))
      t.fail("cylinder", "[stock] cylinder must be [radius, height], both positive");
    return StockCylinder{2 * v[0], v[1]};
  }
  if (t.has("mesh")) return StockMesh{reader.file(t, "mesh")};
  if (t.has("relief")) {
    StockRelief relief{reader.file(t, "relief")};
    relief.size.width_mm = t.positive("width_mm");
    relief.size.height_mm = t.positive("height_mm");
    relief.size.base_mm = t.positive("base_mm");
    return relief;
  }
  if (t.has("volume")) {
    StockVolume volume{reader.file(t, "volume")};
    read_labels(reader, t, volume.labels);
    return volume;
  }
  return {};
}

// Returns the stock's shape if it is a Shape. Otherwise reports an error for keys that only a Shape
// has.
template <class Shape>
Shape* only_of(const TableReader& t, Stock& stock, std::initializer_list<const char*> keys) {
  auto* const shape = std::get_if<Shape>(&stock.shape);
  for (const char* key : keys)
    if (t.has(key) && !shape) t.fail(key, t.full(key) + " needs " + Shape::kKind);
  return shape;
}

Orientation read_orientation(const TableReader& t) {
  const auto read = [&](const char* key, SignedAxis otherwise) {
    if (!t.has(key)) return otherwise;
    const auto axis = parse_signed_axis(t.text(key));
    if (!axis)
      t.fail(key,
             t.full(key) + R"( must be "x", "-x", "y", "-y", "z" or "-z", an axis of the file)");
    return axis.value_or(otherwise);
  };
  Orientation orientation = standing(read("up", SignedAxis::plus_z));
  orientation.front = read("front", orientation.front);
  if (is_turn(orientation)) return orientation;
  t.fail("front", "[stock] front must be at right angles to up");
  return {};
}

void read_layer(SceneReader& reader, const TableReader& t) {
  t.only({"tool", "place", "axis", "roll_deg", "material"});
  StockLayer layer;
  layer.line = t.line();
  layer.shape = read_shape(reader, t);
  if (t.failed()) return;
  layer.pose = {t.vector("place"), read_frame(t)};
  layer.material = reader.material(t, "material");
  std::vector<StockLayer>& layers = reader.scene.stock.layers;
  if (layers.size() >= kMaxLayers)
    return t.fail("a scene may have at most " + std::to_string(kMaxLayers) + " layers; use fewer");
  layers.push_back(std::move(layer));
}

}  // namespace

void read_stock(SceneReader& reader, const TableReader& root) {
  const std::optional<TableReader> found = root.section("stock", true);
  if (!found) return;
  const TableReader& t = *found;
  t.only({"block", "mesh", "sphere", "cylinder", "relief", "pitch", "material", "fit_mm", "room_mm",
          "width_mm", "height_mm", "base_mm", "invert", "up", "front", "volume", "labels", "log"});
  Stock& stock = reader.scene.stock;
  stock.line = t.line();
  stock.shape = read_kind(reader, t);
  const auto* const volume = only_of<StockVolume>(t, stock, {"labels"});
  if (auto* const relief =
          only_of<StockRelief>(t, stock, {"width_mm", "height_mm", "base_mm", "invert"}))
    relief->size.invert = t.flag_or("invert", false);
  if (auto* const mesh = only_of<StockMesh>(t, stock, {"up", "front", "fit_mm"})) {
    mesh->orientation = read_orientation(t);
    if (t.has("fit_mm")) mesh->fit_mm = t.positive("fit_mm");
  }
  stock.pitch_mm = t.positive("pitch");
  if (t.has("room_mm")) t.not_negative("room_mm", stock.room_mm.emplace());
  if (volume && !volume->labels.empty()) stock.material = volume->labels.begin()->second;
  if (t.has("material"))
    stock.material = reader.material(t, "material");
  else if (reader.scene.materials.empty())
    reader.add_material(t.line(), reader.default_material("material"));
  if (const auto log =
          t.table("log", "log = { ring_width = 2, axis = [1, 0, 0], pith = [0, 0, -50] }")) {
    log->only(TableReader::keys_of<LogCut>());
    LogCut cut = reader.scene.materials[stock.material].log;
    log->fields(cut);
    if (log->has("pith") != log->has("axis"))
      log->fail(log->full("axis and pith need each other; give both"));
    if (log->has("axis") && cut.axis.isZero(0))
      log->fail("axis", log->full("axis must not be zero"));
    stock.log = cut;
  }
  root.for_tables("layer", "layers of another material are written as [[layer]]",
                  [&](const TableReader& layer) { read_layer(reader, layer); });
}

}  // namespace kibori
