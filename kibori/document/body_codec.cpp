// SPDX-License-Identifier: MIT
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>

#include <limits>

#include <kibori/base/file.h>
#include <kibori/document/json_fields.h>

namespace kibori {
namespace {

constexpr int kMaxId = std::numeric_limits<int>::max() - static_cast<int>(kMaxBodies);

Json pose_to_json(const Pose& pose) {
  return {{"tip_mm", vec(pose.tip)},
          {"axes", {vec(pose.frame.col(0)), vec(pose.frame.col(1)), vec(pose.frame.col(2))}}};
}

bool read_pose(const Json& json, Pose& pose) {
  if (!json.is_object() || !read_vec(json.value("tip_mm", Json()), pose.tip)) return false;
  const Json axes = json.value("axes", Json());
  if (!axes.is_array() || axes.size() != 3) return false;
  for (size_t i = 0; i < 3; i++) {
    Vec3 axis;
    if (!read_vec(axes[i], axis)) return false;
    pose.frame.col(static_cast<int>(i)) = axis;
  }
  return true;
}

Json places_to_json(const std::vector<Vec3>& places) {
  Json list = Json::array();
  for (const Vec3& p : places) list.push_back(vec(p));
  return list;
}

bool read_places(const Json& json, size_t max_count, std::vector<Vec3>& places) {
  if (!json.is_array() || json.size() > max_count) return false;
  for (const Json& item : json)
    if (!read_vec(item, places.emplace_back())) return false;
  return true;
}

Json to_json(const CutPlane& cut) {
  return {{"point_mm", vec(cut.point_mm)}, {"normal", vec(cut.normal)}};
}
Json to_json(const CutCurve& cut) {
  Json json{{"along", vec(cut.along)}, {"closed", cut.closed}, {"smooth", cut.smooth}};
  if (!cut.curve_mm.empty()) json["curve_mm"] = places_to_json(cut.curve_mm);
  return json;
}
Json to_json(const Cutter& cutter) {
  Json json = std::visit([](const auto& shape) { return to_json(shape); }, cutter.shape);
  if (cutter.kerf_mm > 0) json["kerf_mm"] = cutter.kerf_mm;
  return json;
}

bool read_flag(const Json& json, const char* key, bool& flag) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!found->is_boolean()) return false;
  flag = found->get<bool>();
  return true;
}

Result<Cutter> cutter_of(const Json& json) {
  const Error none{"a cutter must be a JSON object with a point and a normal, or with a curve"};
  if (!json.is_object()) return none;
  Cutter cutter;
  Fields fields{json};
  if (const auto curve = json.find("curve_mm"); curve != json.end()) {
    CutCurve& cut = cutter.shape.emplace<CutCurve>();
    if (!read_places(*curve, kMaxCurvePoints, cut.curve_mm)) return none;
    fields.get("along", cut.along);
    if (!read_flag(json, "closed", cut.closed) || !read_flag(json, "smooth", cut.smooth))
      return none;
  } else {
    CutPlane& cut = cutter.shape.emplace<CutPlane>();
    fields.get("point_mm", cut.point_mm);
    fields.get("normal", cut.normal);
  }
  if (json.contains("kerf_mm")) fields.get("kerf_mm", cutter.kerf_mm);
  if (!fields.wrong.empty()) return Error{"a cutter " + fields.wrong};
  if (const Status fits = check_cutter(cutter); !fits) return Error{fits.error()};
  return cutter;
}

Json spline_to_json(const BodySpline& spline) {
  const SplineShape& shape = spline.shape;
  Json json{{"kind", name_of(shape.kind)},
            {"operation", name_of(spline.operation)},
            {"closed", shape.curve.closed},
            {"interpolate", shape.curve.interpolate},
            {"points_mm", places_to_json(shape.curve.points_mm)}};
  if (shape.kind == SplineKind::extrude) {
    json["direction"] = vec(shape.direction);
    json["length_mm"] = shape.length_mm;
  }
  if (shape.kind == SplineKind::revolve) {
    json["axis_point_mm"] = vec(shape.axis_point_mm);
    json["axis"] = vec(shape.axis);
  }
  if (shape.kind == SplineKind::sweep) json["radius_mm"] = shape.radius_mm;
  return json;
}

Status read_spline(const Json& json, BodySpline& spline) {
  const Error none{"a spline must be a JSON object with a kind, an operation and points_mm"};
  if (!json.is_object()) return none;
  SplineShape& shape = spline.shape;
  Fields fields{json};
  std::string kind, operation;
  fields.get("kind", kind);
  fields.get("operation", operation);
  const auto known_kind = value_of<SplineKind>(kind);
  const auto known_operation = value_of<SplineOperation>(operation);
  if (!known_kind || !known_operation) return none;
  shape.kind = *known_kind;
  spline.operation = *known_operation;
  if (!read_places(json.value("points_mm", Json()), kMaxSplinePoints, shape.curve.points_mm) ||
      !read_flag(json, "closed", shape.curve.closed) ||
      !read_flag(json, "interpolate", shape.curve.interpolate))
    return none;
  if (shape.kind == SplineKind::extrude) {
    fields.get("direction", shape.direction);
    fields.get("length_mm", shape.length_mm);
  }
  if (shape.kind == SplineKind::revolve) {
    fields.get("axis_point_mm", shape.axis_point_mm);
    fields.get("axis", shape.axis);
  }
  if (shape.kind == SplineKind::sweep) fields.get("radius_mm", shape.radius_mm);
  if (!fields.wrong.empty()) return Error{"a spline " + fields.wrong};
  return Ok{};
}

bool is_name(const std::string& name) { return !name.empty() && name.size() <= 100; }

void put(const BodyProperties& properties, Json& json) {
  if (properties.name) json["name"] = *properties.name;
  if (properties.visible) json["visible"] = *properties.visible;
  if (properties.locked) json["locked"] = *properties.locked;
  if (properties.no_go) json["no_go"] = *properties.no_go;
}

Status read(const Json& json, BodyProperties& properties) {
  if (json.contains("name")) {
    Fields fields{json};
    fields.get("name", properties.name.emplace());
    if (!is_name(*properties.name)) return Error{"a body's name must have 1 to 100 bytes"};
  }
  for (const auto& [key, flag] : {std::pair{"visible", &properties.visible},
                                  {"locked", &properties.locked},
                                  {"no_go", &properties.no_go}})
    if (json.contains(key) && !read_flag(json, key, flag->emplace()))
      return Error{std::string("a body's '") + key + "' must be true or false"};
  return Ok{};
}

Json tool_json(const Tool& tool) { return parse_json(tool_to_json(tool)); }

Status read(const Json& json, Tool& tool) {
  Result<Tool> read = tool_from_json(json.dump(-1, ' ', false, Json::error_handler_t::replace));
  if (!read) return Error{read.error()};
  tool = std::move(read).value();
  return Ok{};
}

Status read_material(const Json& json, uint8_t& material) {
  Fields fields{json};
  int number = 0;
  fields.get("material", number, 0, static_cast<int>(kMaxMaterials) - 1);
  if (!fields.wrong.empty()) return Error{"an action on bodies " + fields.wrong};
  material = static_cast<uint8_t>(number);
  return Ok{};
}

Status read(const Json& json, Pose& pose) {
  if (read_pose(json, pose)) return Ok{};
  return Error{"a body's pose must be a position and three axes"};
}

// Writes and reads the data of a verb in the action's JSON. Each verb with data has its own
// overloads.
template <class Verb>
concept Bare = std::is_empty_v<Verb>;
void put(const Bare auto&, Json&) {}
Status read(const Json&, Bare auto&) { return Ok{}; }

void put(const BodyCut& verb, Json& json) { json["cutter"] = to_json(verb.cutter); }
Status read(const Json& json, BodyCut& verb) {
  Result<Cutter> cutter = cutter_of(json.value("cutter", Json()));
  if (!cutter) return Error{cutter.error()};
  verb.cutter = std::move(cutter).value();
  return Ok{};
}

void put(const BodyMirror& verb, Json& json) { json["cutter"] = to_json(verb.plane); }
Status read(const Json& json, BodyMirror& verb) {
  const Result<Cutter> cutter = cutter_of(json.value("cutter", Json()));
  if (!cutter) return Error{cutter.error()};
  if (const auto* plane = std::get_if<CutPlane>(&cutter.value().shape)) verb.plane = *plane;
  return Ok{};
}

void put(const BodyMove& verb, Json& json) { json["pose"] = pose_to_json(verb.pose); }
Status read(const Json& json, BodyMove& verb) {
  return read(json.value("pose", Json()), verb.pose);
}

void put(const BodySet& verb, Json& json) { put(verb.properties, json); }
Status read(const Json& json, BodySet& verb) { return read(json, verb.properties); }

void put(const BodyAdd& verb, Json& json) {
  json["tool"] = tool_json(verb.tool);
  json["material"] = verb.material;
  json["pose"] = pose_to_json(verb.pose);
  put(verb.properties, json);
}
Status read(const Json& json, BodyAdd& verb) {
  if (Status s = read(json.value("tool", Json()), verb.tool); !s) return s;
  if (Status s = read_material(json, verb.material); !s) return s;
  if (Status s = read(json.value("pose", Json()), verb.pose); !s) return s;
  return read(json, verb.properties);
}

void put(const BodyProtect& verb, Json& json) {
  json["tool"] = tool_json(verb.tool);
  json["operation"] = name_of(verb.operation);
  json["follows"] = verb.follows;
  json["way_mm"] = places_to_json(verb.path_mm);
  put(verb.properties, json);
}
Status read(const Json& json, BodyProtect& verb) {
  Fields fields{json};
  std::string operation = "deposit";
  if (json.contains("operation")) fields.get("operation", operation);
  const auto known = value_of<SplineOperation>(operation);
  if (!known || *known == SplineOperation::intersect)
    return Error{"the operation of a mask must be deposit or cut"};
  verb.operation = *known;
  verb.follows = false;  // before version 11
  if (!read_flag(json, "follows", verb.follows)) return Error{"follows must be true or false"};
  const Json path_json = json.value("way_mm", Json());
  if (!path_json.is_array() || path_json.size() > kMaxPathPoints)
    return Error{"way_mm must be a list of at most " + std::to_string(kMaxPathPoints) + " points"};
  if (!read_places(path_json, kMaxPathPoints, verb.path_mm))
    return Error{"a point of way_mm must be three numbers"};
  if (Status s = read(json.value("tool", Json()), verb.tool); !s) return s;
  return read(json, verb.properties);
}

void put(const BodySpline& verb, Json& json) {
  json["spline"] = spline_to_json(verb);
  json["material"] = verb.material;
}
Status read(const Json& json, BodySpline& verb) {
  if (Status s = read_spline(json.value("spline", Json()), verb); !s) return s;
  return read_material(json, verb.material);
}

}  // namespace

std::string action_to_json(const BodyAction& action) {
  Json json{{"verb", verb_of(action)}, {"bodies", action.bodies}};
  std::visit([&](const auto& verb) { put(verb, json); }, action.verb);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<BodyAction> action_from_json(const std::string& text) {
  const Json json = parse_json(text);
  if (!json.is_object()) return Error{"an action on bodies must be a JSON object"};
  Fields fields{json};
  std::string name;
  fields.get("verb", name);
  std::optional<BodyVerb> known = default_verb(name);
  if (!known) return Error{"there is no action on bodies '" + sanitize_message(name) + "'"};
  BodyAction action{{}, std::move(*known)};
  const Json bodies = json.value("bodies", Json::array());
  if (!bodies.is_array() || bodies.size() > kMaxBodies)
    return Error{"bodies must be a list of body numbers"};
  for (const Json& id : bodies) {
    if (!id.is_number_integer() || !(id.get<double>() >= 1 && id.get<double>() <= kMaxId))
      return Error{"bodies must be a list of body numbers"};
    action.bodies.push_back(id.get<int>());
  }
  const Status done =
      std::visit([&](auto& verb) -> Status { return read(json, verb); }, action.verb);
  if (!done) return Error{done.error()};
  return action;
}

std::string bodies_to_json(const BodyList& bodies) {
  Json list = Json::array();
  for (const Body& body : bodies.all) {
    list.push_back({{"id", body.id},
                    {"name", body.name},
                    {"pose", pose_to_json(body.pose)},
                    {"visible", body.visible},
                    {"locked", body.locked}});
    if (body.no_go) list.back()["no_go"] = true;
    if (body.mask_of) list.back()["mask_of"] = body.mask_of;
  }
  return Json{{"next", bodies.next}, {"bodies", list}}.dump(-1, ' ', false,
                                                            Json::error_handler_t::replace);
}

Result<BodyList> bodies_from_json(const std::string& text) {
  const Json json = parse_json(text);
  const Error none{"the list of its bodies is invalid"};
  if (!json.is_object()) return none;
  BodyList bodies;
  Fields fields{json};
  fields.get("next", bodies.next, 2, kMaxId);
  const Json list = json.value("bodies", Json());
  if (!list.is_array() || list.empty() || list.size() > kMaxBodies) return none;
  for (const Json& item : list) {
    if (!item.is_object()) return none;
    Body body;
    Fields f{item};
    f.get("id", body.id, 1, bodies.next - 1);
    f.get("name", body.name);
    if (item.contains("mask_of")) f.get("mask_of", body.mask_of, 1, bodies.next - 1);
    if (!f.wrong.empty() || !is_name(body.name) || bodies.find(body.id) ||
        !read_pose(item.value("pose", Json()), body.pose) || !is_rigid(body.pose) ||
        !read_flag(item, "visible", body.visible) || !read_flag(item, "locked", body.locked) ||
        (item.contains("no_go") && !read_flag(item, "no_go", body.no_go)))
      return none;
    bodies.all.push_back(std::move(body));
  }
  if (!fields.wrong.empty()) return none;
  return bodies;
}

}  // namespace kibori
