// SPDX-License-Identifier: MIT
#include <kibori/scene/stock_codec.h>

#include <algorithm>
#include <type_traits>

#include <kibori/base/json.h>
#include <kibori/body/bodies.h>
#include <kibori/document/codec.h>

namespace kibori {
namespace {

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json layer_to_json(const StockLayer& layer) {
  Json pose = Json::array();
  for (const double number : layer.pose.tip) pose.push_back(number);
  for (const double number : layer.pose.frame.reshaped()) pose.push_back(number);
  return {{"tool", parse_json(tool_to_json(layer.shape))},
          {"pose", std::move(pose)},
          {"material", layer.material}};
}

Result<StockLayer> layer_from_json(const Json& json) {
  const Error wrong{"has a stock whose layers can't be read; run 'kibori verify'"};
  StockLayer layer;
  if (!json.is_object()) return wrong;
  Result<Tool> shape = tool_from_json(json.value("tool", Json()).dump());
  const Json pose = json.value("pose", Json()), material = json.value("material", Json());
  if (!shape || !pose.is_array() || pose.size() != 12 || !material.is_number_integer() ||
      material < 0 || material >= kMaxMaterials)
    return wrong;
  layer.shape = std::move(shape).value();
  for (size_t i = 0; i < 12; i++) {
    if (!pose[i].is_number()) return wrong;
    (i < 3 ? layer.pose.tip.data()[i] : layer.pose.frame.data()[i - 3]) = pose[i].get<double>();
  }
  if (!layer.pose.tip.allFinite() || !is_rigid(layer.pose)) return wrong;
  layer.material = material.get<uint8_t>();
  return layer;
}

// The number at this key; 0 if it is missing or not a number.
double number(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number() ? found->get<double>() : 0;
}

bool read_axis(const Json& json, const char* key, SignedAxis& axis) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  const auto read =
      found->is_string() ? parse_signed_axis(found->get<std::string>()) : std::nullopt;
  axis = read.value_or(axis);
  return read.has_value();
}

// For each shape, put() writes its fields to the JSON, except the size and the file. read() reads
// all fields except the file. It returns false if they are invalid.
void put(const StockBlock&, Json&) {}
bool read(const Json&, const Vec3& size, StockBlock& shape) {
  shape.size_mm = size;
  return true;
}

void put(const StockSphere&, Json&) {}
bool read(const Json&, const Vec3& size, StockSphere& shape) {
  shape.diameter_mm = size.x();
  return true;
}

void put(const StockCylinder&, Json&) {}
bool read(const Json&, const Vec3& size, StockCylinder& shape) {
  shape = {size.x(), size.z()};
  return true;
}

void put(const StockMesh& shape, Json& json) {
  if (shape.fit_mm) json["fit_mm"] = *shape.fit_mm;
  if (shape.orientation == Orientation{}) return;
  json["up"] = signed_axis_text(shape.orientation.up);
  json["front"] = signed_axis_text(shape.orientation.front);
}
bool read(const Json& json, const Vec3&, StockMesh& shape) {
  if (json.contains("fit_mm")) shape.fit_mm = number(json, "fit_mm");
  return read_axis(json, "up", shape.orientation.up) &&
         read_axis(json, "front", shape.orientation.front) && is_turn(shape.orientation);
}

void put(const StockRelief& shape, Json& json) {
  const ReliefSize& size = shape.size;
  json.update(
      {{"width_mm", size.width_mm}, {"height_mm", size.height_mm}, {"base_mm", size.base_mm}});
  if (size.invert) json["invert"] = true;
}
bool read(const Json& json, const Vec3&, StockRelief& shape) {
  shape.size = {number(json, "width_mm"), number(json, "height_mm"), number(json, "base_mm"),
                json.value("invert", Json()) == true};
  return true;
}

void put(const StockVolume& shape, Json& json) {
  for (const auto& [label, material] : shape.labels) json["labels"].push_back({label, material});
}
bool read(const Json& json, const Vec3&, StockVolume& shape) {
  const Json labels = json.value("labels", Json::array());
  if (!labels.is_array()) return false;
  for (const Json& pair : labels) {
    if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() ||
        !pair[1].is_number_unsigned() || pair[0] > 65535 || pair[1] >= kMaxMaterials)
      return false;
    shape.labels[pair[0].get<uint16_t>()] = pair[1].get<uint8_t>();
  }
  return true;
}

std::optional<StockShape> shape_of_kind(const Json& kind) {
  std::optional<StockShape> shape;
  const auto take = [&]<class... Shape>(std::type_identity<std::variant<Shape...>>) {
    static_cast<void>(((kind == Shape::kKind && (shape = Shape{}, true)) || ...));
  };
  take(std::type_identity<StockShape>());
  return shape;
}

}  // namespace

std::string stock_to_json(const Stock& stock, const std::string& label,
                          const std::vector<Material>& materials) {
  const Vec3 size = size_mm(stock.shape);
  Json json{{"size_mm", {size.x(), size.y(), size.z()}},
            {"pitch_mm", stock.pitch_mm},
            {"material", stock.material},
            {"label", label},
            {"materials", parse_json(materials_to_json(materials))}};
  if (stock.room_mm) json["room_mm"] = *stock.room_mm;
  if (const std::filesystem::path* file = file_of(stock)) json["file"] = file->filename().string();
  const auto put_shape = [&](const auto& shape) {
    json["kind"] = shape.kKind;
    put(shape, json);
  };
  std::visit(put_shape, stock.shape);
  for (const StockLayer& layer : stock.layers) json["layers"].push_back(layer_to_json(layer));
  return text_of(json);
}

std::string stock_to_json(const std::vector<Material>& materials) {
  return text_of(Json{{"materials", parse_json(materials_to_json(materials))}});
}

Result<Stock> stock_from_json(const std::string& text) {
  const Json json = parse_json(text);
  const Error none{
      "the description of its stock is missing or damaged, so it can't be carved at another pitch"};
  if (!json.is_object()) return none;
  Vec3 size;
  const Json written = json.value("size_mm", Json());
  if (!written.is_array() || written.size() != 3) return none;
  for (size_t i = 0; i < 3; i++) {
    if (!written[i].is_number()) return none;
    size[static_cast<int>(i)] = written[i].get<double>();
  }
  std::optional<StockShape> shape = shape_of_kind(json.value("kind", Json()));
  const auto read_shape = [&](auto& known) { return read(json, size, known); };
  if (!shape || !size.allFinite() || !std::visit(read_shape, *shape)) return none;
  Stock stock;
  stock.shape = std::move(*shape);
  stock.pitch_mm = number(json, "pitch_mm");
  stock.material = static_cast<uint8_t>(std::clamp(number(json, "material"), 0.0, 63.0));
  if (json.contains("room_mm")) stock.room_mm = number(json, "room_mm");
  if (std::filesystem::path* const file = file_of(stock))
    if (const Json name = json.value("file", Json()); name.is_string())
      *file = name.get<std::string>();
  if (const auto layers = json.find("layers"); layers != json.end()) {
    if (!layers->is_array() || layers->size() > kMaxLayers) return none;
    for (const Json& one : *layers) {
      Result<StockLayer> layer = layer_from_json(one);
      if (!layer) return Error{layer.error()};
      stock.layers.push_back(std::move(layer).value());
    }
  }
  return stock;
}

std::string stock_label(const std::string& text) {
  const Json json = parse_json(text);
  const auto label = json.find("label");
  return label != json.end() && label->is_string() ? label->get<std::string>() : std::string();
}

std::vector<Material> stock_materials(const std::string& text) {
  const Json stock = parse_json(text);
  if (!stock.is_object() || !stock.contains("materials")) return {};
  const Result<std::vector<Material>> read = materials_from_json(text_of(stock["materials"]));
  return read ? read.value() : std::vector<Material>();
}

}  // namespace kibori
