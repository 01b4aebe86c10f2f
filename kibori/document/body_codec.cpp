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

Json cutter_to_json(const Cutter& cutter) {
  Json json;
  if (cutter.kind == Cutter::Kind::plane) {
    json["point_mm"] = vec(cutter.point_mm);
    json["normal"] = vec(cutter.normal);
  } else {
    json["along"] = vec(cutter.along);
    json["closed"] = cutter.closed;
    json["smooth"] = cutter.smooth;
    for (const Vec3& p : cutter.curve_mm) json["curve_mm"].push_back(vec(p));
  }
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
  const Error none{"a cutter must be a JSON object of a point and a normal, or of a curve"};
  if (!json.is_object()) return none;
  Cutter cutter;
  Fields fields{json};
  if (const auto curve = json.find("curve_mm"); curve != json.end()) {
    cutter.kind = Cutter::Kind::curve;
    if (!curve->is_array() || curve->size() > kMaxCurvePoints) return none;
    for (const Json& item : *curve) {
      Vec3 place;
      if (!read_vec(item, place)) return none;
      cutter.curve_mm.push_back(place);
    }
    fields.get("along", cutter.along);
    if (!read_flag(json, "closed", cutter.closed) || !read_flag(json, "smooth", cutter.smooth))
      return none;
  } else {
    fields.get("point_mm", cutter.point_mm);
    fields.get("normal", cutter.normal);
  }
  if (json.contains("kerf_mm")) fields.get("kerf_mm", cutter.kerf_mm);
  if (!fields.wrong.empty()) return Error{"a cutter " + fields.wrong};
  if (const Status fits = check_cutter(cutter); !fits) return Error{fits.error()};
  return cutter;
}

Json spline_to_json(const SplineShape& shape, SplineOperation operation) {
  Json json{{"kind", name_of(shape.kind)},
            {"operation", name_of(operation)},
            {"closed", shape.curve.closed},
            {"interpolate", shape.curve.interpolate},
            {"points_mm", Json::array()}};
  for (const Vec3& p : shape.curve.points_mm) json["points_mm"].push_back(vec(p));
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

Status read_spline(const Json& json, BodyAction& action) {
  const Error none{"a spline must be a JSON object of a kind, an operation and points_mm"};
  if (!json.is_object()) return none;
  SplineShape& shape = action.spline.emplace();
  Fields fields{json};
  std::string kind, operation;
  fields.get("kind", kind);
  fields.get("operation", operation);
  const auto known_kind = value_of<SplineKind>(kind);
  const auto known_operation = value_of<SplineOperation>(operation);
  const Json points = json.value("points_mm", Json());
  if (!known_kind || !known_operation || !points.is_array() || points.size() > kMaxSplinePoints)
    return none;
  shape.kind = *known_kind;
  action.operation = *known_operation;
  for (const Json& item : points) {
    Vec3 place;
    if (!read_vec(item, place)) return none;
    shape.curve.points_mm.push_back(place);
  }
  if (!read_flag(json, "closed", shape.curve.closed) ||
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

}  // namespace

std::string action_to_json(const BodyAction& action) {
  Json json{{"verb", name_of(action.verb)}, {"bodies", action.bodies}};
  if (action.verb == BodyVerb::cut || action.verb == BodyVerb::mirror)
    json["cutter"] = cutter_to_json(action.cutter);
  if (action.verb == BodyVerb::spline && action.spline)
    json["spline"] = spline_to_json(*action.spline, action.operation);
  if (action.verb == BodyVerb::spline) json["material"] = action.material;
  if (action.verb == BodyVerb::add) {
    if (action.tool) json["tool"] = Json::parse(tool_to_json(*action.tool));
    json["material"] = action.material;
  }
  if (action.verb == BodyVerb::protect) {
    if (action.tool) json["tool"] = Json::parse(tool_to_json(*action.tool));
    json["operation"] = name_of(action.operation);
    json["follows"] = action.follows;
    json["way_mm"] = Json::array();
    for (const Vec3& p : action.way_mm) json["way_mm"].push_back(vec(p));
  }
  if (action.verb == BodyVerb::move || action.verb == BodyVerb::add)
    json["pose"] = pose_to_json(action.pose);
  if (action.name) json["name"] = *action.name;
  if (action.visible) json["visible"] = *action.visible;
  if (action.locked) json["locked"] = *action.locked;
  if (action.no_go) json["no_go"] = *action.no_go;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<BodyAction> action_from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return Error{"what is done with bodies must be a JSON object"};
  BodyAction action;
  Fields fields{json};
  std::string verb;
  fields.get("verb", verb);
  const auto known = value_of<BodyVerb>(verb);
  if (!known)
    return Error{"nothing that is done with bodies is called '" + sanitize_message(verb) + "'"};
  action.verb = *known;
  const Json bodies = json.value("bodies", Json::array());
  if (!bodies.is_array() || bodies.size() > kMaxBodies)
    return Error{"bodies must be a list of numbers"};
  for (const Json& id : bodies) {
    if (!id.is_number_integer() || !(id.get<double>() >= 1 && id.get<double>() <= kMaxId))
      return Error{"bodies must be a list of numbers"};
    action.bodies.push_back(id.get<int>());
  }
  if (action.verb == BodyVerb::cut || action.verb == BodyVerb::mirror) {
    Result<Cutter> cutter = cutter_of(json.value("cutter", Json()));
    if (!cutter) return Error{cutter.error()};
    action.cutter = std::move(cutter).value();
  }
  if (action.verb == BodyVerb::protect) {
    const Json way = json.value("way_mm", Json());
    std::string operation = "deposit";
    if (json.contains("operation")) fields.get("operation", operation);
    const auto known_operation = value_of<SplineOperation>(operation);
    if (!known_operation || *known_operation == SplineOperation::intersect)
      return Error{"what is protected has the operation deposit, or cut"};
    action.operation = *known_operation;
    action.follows = false;  // before version 11
    if (json.contains("follows") && !read_flag(json, "follows", action.follows))
      return Error{"whether a mask follows its body is true or false"};
    if (!way.is_array() || way.size() > kMaxWayPoints)
      return Error{"way_mm must be a list of at most " + std::to_string(kMaxWayPoints) + " places"};
    for (const Json& item : way) {
      Vec3 place;
      if (!read_vec(item, place)) return Error{"a place of way_mm must be three numbers"};
      action.way_mm.push_back(place);
    }
  }
  if (action.verb == BodyVerb::add || action.verb == BodyVerb::protect) {
    Result<Tool> tool = tool_from_json(
        json.value("tool", Json()).dump(-1, ' ', false, Json::error_handler_t::replace));
    if (!tool) return Error{tool.error()};
    action.tool = std::move(tool).value();
  }
  if (action.verb == BodyVerb::spline)
    if (const Status read = read_spline(json.value("spline", Json()), action); !read)
      return Error{read.error()};
  if (action.verb == BodyVerb::add || action.verb == BodyVerb::spline) {
    int material = 0;
    fields.get("material", material, 0, static_cast<int>(kMaxMaterials) - 1);
    action.material = static_cast<uint8_t>(material);
  }
  if ((action.verb == BodyVerb::move || action.verb == BodyVerb::add) &&
      !read_pose(json.value("pose", Json()), action.pose))
    return Error{"a body's pose must be a place and three axes"};
  if (json.contains("name")) {
    action.name.emplace();
    fields.get("name", *action.name);
    if (!is_name(*action.name)) return Error{"a body's name has 1 to 100 bytes"};
  }
  for (const auto& [key, flag] : {std::pair{"visible", &action.visible},
                                  {"locked", &action.locked},
                                  {"no_go", &action.no_go}}) {
    if (!json.contains(key)) continue;
    flag->emplace();
    if (!read_flag(json, key, **flag))
      return Error{std::string("a body's '") + key + "' is true or false"};
  }
  if (!fields.wrong.empty()) return Error{"what is done with bodies " + fields.wrong};
  return action;
}

std::string bodies_to_json(const Bodies& bodies) {
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

Result<Bodies> bodies_from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  const Error none{"its bodies are not as Kibori writes them"};
  if (!json.is_object()) return none;
  Bodies bodies;
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
