// SPDX-License-Identifier: MIT
// [stock] and [[layer]] of a scene.
#include <kibori/scene/scene_reader.h>

#include <charconv>

namespace kibori {
namespace {

using Kind = Stock::Kind;

// Which material the voxels of each label are of: labels = { 1 = "enamel", 2 = "dentine" }.
void read_labels(SceneReader& reader, const TableReader& t, Stock& stock) {
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
    stock.labels[static_cast<uint16_t>(number)] = reader.material(t.line("labels"), *name);
  }
}

void read_kind(SceneReader& reader, const TableReader& t, Stock& stock) {
  int kinds = 0;
  for (const char* kind : {"block", "mesh", "sphere", "cylinder", "relief", "volume"})
    kinds += t.has(kind) ? 1 : 0;
  if (kinds != 1)
    t.fail("[stock] needs exactly one of block, mesh, sphere, cylinder, relief and volume");
  if (t.has("block")) {
    stock.kind = Kind::block;
    stock.size_mm = t.vector("block");
    if (!(stock.size_mm.array() > 0).all())
      t.fail("block", "[stock] block must have three positive sides");
  } else if (t.has("sphere")) {
    stock.kind = Kind::sphere;
    stock.size_mm = Vec3::Constant(2 * t.positive("sphere"));
  } else if (t.has("cylinder")) {
    stock.kind = Kind::cylinder;
    const auto v = t.numbers("cylinder", 2);
    if (!(v[0] > 0 && v[1] > 0))
      t.fail("cylinder", "[stock] cylinder must be [radius, height], both positive");
    stock.size_mm = {2 * v[0], 2 * v[0], v[1]};
  } else if (t.has("mesh")) {
    stock.kind = Kind::mesh;
    stock.mesh_path = reader.file(t, "mesh");
  } else if (t.has("relief")) {
    stock.kind = Kind::relief;
    stock.mesh_path = reader.file(t, "relief");
    stock.width_mm = t.positive("width_mm");
    stock.height_mm = t.positive("height_mm");
    stock.base_mm = t.positive("base_mm");
  } else if (t.has("volume")) {
    stock.kind = Kind::volume;
    stock.mesh_path = reader.file(t, "volume");
    read_labels(reader, t, stock);
  }
}

// Keys of one kind of stock only.
void goes_with(const TableReader& t, const Stock& stock, Kind kind, const char* name,
               std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (t.has(key) && stock.kind != kind) t.fail(key, t.full(key) + " goes with " + name);
}

void read_orientation(const TableReader& t, Stock& stock) {
  const auto read = [&](const char* key, SignedAxis otherwise) {
    if (!t.has(key)) return otherwise;
    goes_with(t, stock, Kind::mesh, "mesh", {key});
    const auto axis = parse_signed_axis(t.text(key));
    if (!axis)
      t.fail(key,
             t.full(key) + R"( must be "x", "-x", "y", "-y", "z" or "-z", an axis of the file)");
    return axis.value_or(otherwise);
  };
  stock.orientation = standing(read("up", SignedAxis::plus_z));
  stock.orientation.front = read("front", stock.orientation.front);
  if (is_turn(stock.orientation)) return;
  t.fail("front", "[stock] front must be at right angles to up");
  stock.orientation = {};
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
    return t.fail("a scene can hold at most " + std::to_string(kMaxLayers) + " layers");
  layers.push_back(std::move(layer));
}

}  // namespace

void read_stock(SceneReader& reader, const TableReader& root) {
  const std::optional<TableReader> found = root.section("stock", true);
  if (!found) return;
  const TableReader& t = *found;
  t.only({"block", "mesh", "sphere", "cylinder", "relief", "pitch", "material", "fit_mm", "room_mm",
          "width_mm", "height_mm", "base_mm", "invert", "up", "front", "volume", "labels"});
  Stock& stock = reader.scene.stock;
  stock.line = t.line();
  read_kind(reader, t, stock);
  goes_with(t, stock, Kind::volume, "volume", {"labels"});
  goes_with(t, stock, Kind::relief, "relief", {"width_mm", "height_mm", "base_mm", "invert"});
  stock.invert = t.flag_or("invert", false);
  read_orientation(t, stock);
  stock.pitch_mm = t.positive("pitch");
  goes_with(t, stock, Kind::mesh, "mesh", {"fit_mm"});
  if (t.has("fit_mm")) stock.fit_mm = t.positive("fit_mm");
  if (t.has("room_mm")) t.at_least_zero("room_mm", stock.room_mm.emplace());
  if (stock.kind == Kind::volume && !stock.labels.empty())
    stock.material = stock.labels.begin()->second;
  if (t.has("material"))
    stock.material = reader.material(t, "material");
  else if (reader.scene.materials.empty())
    reader.add_material(t.line(), reader.default_material("material"));
  root.for_tables("layer", "what of the stock is of another material is written as [[layer]]",
                  [&](const TableReader& layer) { read_layer(reader, layer); });
}

}  // namespace kibori
