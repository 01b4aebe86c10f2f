// SPDX-License-Identifier: MIT
#include <kibori/scene/stock_codec.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include <kibori/body/bodies.h>
#include <kibori/document/codec.h>

namespace kibori {
namespace {

using Json = nlohmann::json;

constexpr const char* kKinds[] = {"block", "sphere", "cylinder", "mesh", "relief", "volume"};

Json parse(const std::string& text) {
  return Json::parse(text, nullptr, /*allow_exceptions=*/false);
}
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json layer_to_json(const StockLayer& layer) {
  Json pose = Json::array();
  for (const double number : layer.pose.tip) pose.push_back(number);
  for (const double number : layer.pose.frame.reshaped()) pose.push_back(number);
  return {{"tool", Json::parse(tool_to_json(layer.shape))},
          {"pose", std::move(pose)},
          {"material", layer.material}};
}

Result<StockLayer> layer_from_json(const Json& json) {
  const Error wrong{"has a stock whose layers can't be read"};
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

}  // namespace

bool has_file(const Stock& stock) {
  return stock.kind == Stock::Kind::mesh || stock.kind == Stock::Kind::relief ||
         stock.kind == Stock::Kind::volume;
}

std::string stock_to_json(const Stock& stock, const std::string& label,
                          const std::vector<Material>& materials) {
  Json json{{"kind", kKinds[static_cast<size_t>(stock.kind)]},
            {"size_mm", {stock.size_mm.x(), stock.size_mm.y(), stock.size_mm.z()}},
            {"pitch_mm", stock.pitch_mm},
            {"material", stock.material},
            {"label", label},
            {"materials", Json::parse(materials_to_json(materials))}};
  if (stock.room_mm) json["room_mm"] = *stock.room_mm;
  if (stock.fit_mm) json["fit_mm"] = *stock.fit_mm;
  if (stock.invert) json["invert"] = true;
  if (stock.orientation != Orientation{}) {
    json["up"] = signed_axis_text(stock.orientation.up);
    json["front"] = signed_axis_text(stock.orientation.front);
  }
  if (has_file(stock)) json["file"] = stock.mesh_path.filename().string();
  if (stock.kind == Stock::Kind::relief)
    json.update(
        {{"width_mm", stock.width_mm}, {"height_mm", stock.height_mm}, {"base_mm", stock.base_mm}});
  for (const auto& [label_number, material] : stock.labels)
    json["labels"].push_back({label_number, material});
  for (const StockLayer& layer : stock.layers) json["layers"].push_back(layer_to_json(layer));
  return text_of(json);
}

std::string stock_to_json(const std::vector<Material>& materials) {
  return text_of(Json{{"materials", Json::parse(materials_to_json(materials))}});
}

Result<Stock> stock_from_json(const std::string& text) {
  const Json json = parse(text);
  const Error none{"does not say how its stock was made, so it can't be carved at another pitch"};
  if (!json.is_object()) return none;
  Stock stock;
  const auto number = [&](const char* key, double otherwise) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : otherwise;
  };
  int kind = -1;
  for (int i = 0; i < static_cast<int>(std::size(kKinds)); i++)
    if (json.value("kind", Json()) == kKinds[i]) kind = i;
  const Json size = json.value("size_mm", Json());
  if (kind < 0 || !size.is_array() || size.size() != 3) return none;
  stock.kind = static_cast<Stock::Kind>(kind);
  for (size_t i = 0; i < 3; i++)
    stock.size_mm[static_cast<int>(i)] = size[i].is_number() ? size[i].get<double>() : std::nan("");
  stock.pitch_mm = number("pitch_mm", 0);
  stock.material = static_cast<uint8_t>(std::clamp(number("material", 0), 0.0, 63.0));
  if (json.contains("room_mm")) stock.room_mm = number("room_mm", 0);
  if (json.contains("fit_mm")) stock.fit_mm = number("fit_mm", 0);
  if (const Json file = json.value("file", Json()); file.is_string())
    stock.mesh_path = file.get<std::string>();
  stock.width_mm = number("width_mm", 0);
  stock.height_mm = number("height_mm", 0);
  stock.base_mm = number("base_mm", 0);
  stock.invert = json.value("invert", Json()) == true;
  for (const auto& [key, axis] :
       {std::pair{"up", &stock.orientation.up}, {"front", &stock.orientation.front}}) {
    const auto found = json.find(key);
    if (found == json.end()) continue;
    const auto read =
        found->is_string() ? parse_signed_axis(found->get<std::string>()) : std::nullopt;
    if (!read) return none;
    *axis = *read;
  }
  if (!stock.size_mm.allFinite() || !is_turn(stock.orientation)) return none;
  if (const auto labels = json.find("labels"); labels != json.end()) {
    if (!labels->is_array()) return none;
    for (const Json& pair : *labels) {
      if (!pair.is_array() || pair.size() != 2 || !pair[0].is_number_unsigned() ||
          !pair[1].is_number_unsigned() || pair[0] > 65535 || pair[1] >= kMaxMaterials)
        return none;
      stock.labels[pair[0].get<uint16_t>()] = pair[1].get<uint8_t>();
    }
  }
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
  const Json json = parse(text);
  const auto label = json.find("label");
  return label != json.end() && label->is_string() ? label->get<std::string>() : std::string();
}

std::vector<Material> stock_materials(const std::string& text) {
  const Json stock = parse(text);
  if (!stock.is_object() || !stock.contains("materials")) return {};
  const Result<std::vector<Material>> read = materials_from_json(text_of(stock["materials"]));
  return read ? read.value() : std::vector<Material>();
}

}  // namespace kibori
