// SPDX-License-Identifier: MIT
#include <kibori/document/codec.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>

#include <zstd.h>

#include <kibori/base/hash.h>
#include <kibori/document/json_fields.h>
#include <kibori/haptics/materials.h>
#include <kibori/motion/reshape_stroke.h>

static_assert(std::endian::native == std::endian::little, "documents are little-endian");

namespace kibori {
namespace {

constexpr int kLevel = 3;
constexpr size_t kMaxTicks = 1'000'000, kMaxPlanes = 4096;

Bytes compress(const Bytes& raw) {
  Bytes packed(ZSTD_compressBound(raw.size()));
  thread_local const std::unique_ptr<ZSTD_CCtx, size_t (*)(ZSTD_CCtx*)> context(ZSTD_createCCtx(),
                                                                                ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  // With the checksum, the reader detects flipped bits.
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  const size_t size =
      ZSTD_compress2(context.get(), packed.data(), packed.size(), raw.data(), raw.size());
  KIBORI_CHECK(!ZSTD_isError(size));
  packed.resize(size);
  return packed;
}

Result<Bytes> decompress(const Bytes& packed, size_t max) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > max)
    return Error{"cannot be decompressed"};
  Bytes raw(static_cast<size_t>(size));
  thread_local const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(),
                                                                                ZSTD_freeDCtx);
  const size_t got =
      ZSTD_decompressDCtx(context.get(), raw.data(), raw.size(), packed.data(), packed.size());
  if (ZSTD_isError(got) || got != raw.size()) return Error{"is damaged"};
  return raw;
}

template <class T>
void put(Bytes& to, const T* values, size_t count) {
  const size_t at = to.size();
  to.resize(at + count * sizeof(T));
  if (count) std::memcpy(to.data() + at, values, count * sizeof(T));
}

// Reads bytes from the front. take() returns false if too few are left.
struct Reader {
  const Bytes& bytes;
  size_t at = 0;

  template <class T>
  bool take(T* values, size_t count) {
    if (bytes.size() - at < count * sizeof(T)) return false;
    if (count) std::memcpy(values, bytes.data() + at, count * sizeof(T));
    at += count * sizeof(T);
    return true;
  }
  bool done() const { return at == bytes.size(); }
};

// Flags of a tick. Versions before 0.2 do not know kEnd. For them, a tick of a reshaping stroke
// that edits nothing is the stroke's end. The end tick edits nothing, so they can still read this
// format.
constexpr uint8_t kEdits = 1, kSecond = 2, kPut = 4, kEnd = 8, kComputes = 16, kLine = 32,
                  kPressure = 64;
// Number of columns of a tick, and of a force.
constexpr int kColumns = 12, kForceColumns = 6;
constexpr double kMaxLine = std::numeric_limits<int>::max();
template <class T>
auto& column(T& row, int i) {
  if constexpr (std::is_same_v<std::remove_const_t<T>, Wrench>)
    return (i < 3 ? row.force : row.moment)[i % 3];
  else
    return (i < 3 ? row.tip : i < 6 ? row.turn : i < 9 ? row.stretch_mm : row.stretch_rad)[i % 3];
}

Json json_of(const Tool& tool) {
  Json json{{"shape", shape_of(tool)}};
  const auto put = [&](const char* key, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
      json[key] = value;
    else
      json[key] = vec(value);
  };
  for_tool_numbers(tool, put);
  if (const auto* t = std::get_if<MeshTool>(&tool)) {
    Json& vertices = json["vertices"] = Json::array();
    for (const Vec3& p : t->mesh->vertices) vertices.push_back(vec(p));
    Json& triangles = json["triangles"] = Json::array();
    for (const auto& t3 : t->mesh->triangles) triangles.push_back({t3[0], t3[1], t3[2]});
  }
  return json;
}

Json json_of(const StrokeForce& force) {
  const bool series = force.series();
  Json json{{"model", name_of(force.law.model)}};
  if (series) json.update(fields_to_json(force.spring));
  // Defaults are not written, so that the text of older strokes stays the same.
  if (!series || force.law.dof != 5) json["dof"] = force.law.dof;
  const double share = series ? force.spring.hand_share : force.law.hand_share;
  if (share != 1) json["hand_share"] = share;
  if (force.law.model == ForceModel::energy) json["start_resists"] = force.law.start_resists;
  if (force.law.thrust != 0) json["thrust"] = force.law.thrust;
  if (force.law.version > 1) json["version"] = force.law.version;
  return json;
}

Status read_force(const Json& json, double rate_hz, StrokeForce& force) {
  Fields f{json};
  std::string model;
  f.get("model", model);
  const std::optional<ForceModel> named = value_of<ForceModel>(model);
  if (!named) return Error{"there is no force model '" + sanitize_message(model) + "'"};
  force.law.model = *named;
  double& share = force.series() ? force.spring.hand_share : force.law.hand_share;
  if (json.contains("hand_share")) f.get("hand_share", share);
  if (!(share >= 0 && share <= 1)) return Error{"a stroke's hand_share must be from 0 to 1"};
  if (!force.series() || json.contains("dof")) f.get("dof", force.law.dof, 5, 6);
  if (force.series()) {
    if (Status read = fields_from_json(json, "the force", force.spring); !read) return read;
    force.law.hand_share = share;  // brushes read it from the law
    if (!(force.spring.strength_n >= 0)) return Error{"a stroke's strength_n must not be below 0"};
    force.spring.tick_s = 1 / rate_hz;
  } else {
    // Strokes from before this setting have no such key.
    force.law.start_resists = json.value("start_resists", Json(true)) != Json(false);
  }
  force.law.version = 1;
  if (json.contains("thrust")) f.get("thrust", force.law.thrust);
  if (!(force.law.thrust >= 0 && force.law.thrust <= kMaxThrust))
    return Error{"a stroke's thrust must be from 0 to 3"};
  if (json.contains("version")) f.get("version", force.law.version, 1, kForceVersion);
  if (!f.wrong.empty()) return Error{"the force " + f.wrong};
  return Ok{};
}

Status read_tool_mesh(Fields& fields, MeshTool& tool) {
  auto mesh = std::make_shared<TriangleMesh>();
  const Json *vertices = fields.find("vertices"), *triangles = fields.find("triangles");
  if (!vertices || !triangles || !vertices->is_array() || !triangles->is_array())
    return Error{"the tool's mesh is missing"};
  const auto three = [](const Json& v, bool whole) {
    bool good = v.is_array() && v.size() == 3;
    for (size_t i = 0; good && i < 3; i++)
      good = whole ? v[i].is_number_unsigned() : v[i].is_number();
    return good;
  };
  for (const Json& v : *vertices) {
    if (!three(v, false)) return Error{"the tool's mesh has a vertex that is not three numbers"};
    mesh->vertices.emplace_back(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
  }
  for (const Json& v : *triangles) {
    if (!three(v, true))
      return Error{"the tool's mesh has a triangle that is not three vertex indices"};
    const uint64_t a = v[0], b = v[1], c = v[2], max = mesh->vertices.size();
    if (a >= max || b >= max || c >= max)
      return Error{"the tool's mesh has a triangle with a missing vertex"};
    mesh->triangles.push_back(
        {static_cast<uint32_t>(a), static_cast<uint32_t>(b), static_cast<uint32_t>(c)});
  }
  tool.mesh = std::move(mesh);
  return Ok{};
}

Result<Tool> tool_of(const Json& json) {
  Fields fields{json};
  std::string shape;
  fields.get("shape", shape);
  if (!fields.wrong.empty()) return Error{"the tool " + fields.wrong};
  std::optional<Tool> known = default_tool(shape);
  if (!known) return Error{"there is no tool shape '" + sanitize_message(shape) + "'"};
  Tool& tool = *known;
  for_tool_numbers(tool, [&](const char* key, auto& value) { fields.get(key, value); });
  if (auto* mesh = std::get_if<MeshTool>(&tool))
    if (Status s = read_tool_mesh(fields, *mesh); !s) return Error{s.error()};
  if (!fields.wrong.empty()) return Error{"the tool " + fields.wrong};
  if (const Status good = check_tool(tool); !good) return Error{good.error()};
  return std::move(tool);
}

// Writes columns of doubles. Each value is XORed with the previous one of its column. A column
// stores the lowest bytes of all results first, then the next higher bytes, and so on. at(i,
// column) returns double& or double.
template <class At>
void put_columns(Bytes& raw, size_t count, int columns, At&& at) {
  std::vector<uint64_t> bits(count);
  for (int c = 0; c < columns; c++) {
    uint64_t last = 0;
    for (size_t i = 0; i < count; i++) {
      const auto now = std::bit_cast<uint64_t>(at(i, c));
      bits[i] = now ^ std::exchange(last, now);
    }
    for (int byte = 0; byte < 8; byte++)
      for (size_t i = 0; i < count; i++) raw.push_back(static_cast<uint8_t>(bits[i] >> (8 * byte)));
  }
}

// Reads such columns. Returns false if a value is not finite.
template <class At>
bool take_columns(Reader& reader, size_t count, int columns, At&& at) {
  Bytes plane(count);
  for (int c = 0; c < columns; c++) {
    std::vector<uint64_t> bits(count);
    for (int byte = 0; byte < 8; byte++) {
      reader.take(plane.data(), count);
      for (size_t i = 0; i < count; i++) bits[i] |= uint64_t{plane[i]} << (8 * byte);
    }
    uint64_t last = 0;
    for (size_t i = 0; i < count; i++) {
      last ^= bits[i];
      const auto value = std::bit_cast<double>(last);
      if (!std::isfinite(value)) return false;
      at(i, c) = value;
    }
  }
  return true;
}

Bytes greys_of(const AlphaPicture& picture) { return {picture.greys.begin(), picture.greys.end()}; }

// Bytes as text, two hexadecimal digits each.
std::string hex_of(const Bytes& bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}
std::optional<Bytes> bytes_of_hex(const std::string& text) {
  if (text.size() % 2 != 0) return std::nullopt;
  Bytes bytes(text.size() / 2);
  for (size_t i = 0; i < bytes.size(); i++) {
    const char* const pair = text.data() + 2 * i;
    if (std::from_chars(pair, pair + 2, bytes[i], 16).ptr != pair + 2) return std::nullopt;
  }
  return bytes;
}

Json json_of(const Brush& brush, Mode mode) {
  Json json = fields_to_json(brush);
  if (mode == Mode::paint) json["color"] = brush.color;
  if (brush.flatten_to == FlattenTo::plane) json["plane"] = fields_to_json(brush.plane);
  if (brush.pressure != PressureUse::none) json["pressure"] = name_of(brush.pressure);
  if (brush.alpha == Alpha::picture) json["picture"] = hex_of(compress(greys_of(*brush.picture)));
  return json;
}

Status read_picture(const Json& json, Brush& brush) {
  const Error none{"the brush's picture is missing or damaged"};
  if (!json.is_string()) return none;
  const std::optional<Bytes> packed = bytes_of_hex(json.get_ref<const std::string&>());
  if (!packed) return none;
  auto picture = std::make_shared<AlphaPicture>();
  const Result<Bytes> greys = decompress(*packed, picture->greys.size());
  if (!greys || greys.value().size() != picture->greys.size()) return none;
  std::copy(greys.value().begin(), greys.value().end(), picture->greys.begin());
  brush.picture = std::move(picture);
  return Ok{};
}

Status read_brush(const Json& json, Brush& brush) {
  if (Status read = fields_from_json(json, "the brush", brush); !read) return read;
  read_color(json, "color", brush.color);
  if (json.contains("pressure")) {
    const Json& name = json["pressure"];
    const auto use =
        name.is_string() ? value_of<PressureUse>(name.get_ref<const std::string&>()) : std::nullopt;
    if (!use) return Error{"the brush's pressure must be none, size, strength or both"};
    brush.pressure = *use;
  }
  if (brush.alpha == Alpha::picture)
    if (Status read = read_picture(json.value("picture", Json()), brush); !read) return read;
  if (brush.flatten_to != FlattenTo::plane) return Ok{};
  const Json plane = json.value("plane", Json());
  if (!plane.is_object()) return Error{"the brush has no plane to flatten to"};
  return fields_from_json(plane, "the brush's plane", brush.plane);
}

Json json_of(const std::vector<Material>& materials) {
  Json list = Json::array();
  for (const Material& material : materials) list.push_back(fields_to_json(material));
  return list;
}

Status read_materials(const Json& json, std::vector<Material>& materials) {
  if (!json.is_array() || json.empty() || json.size() > static_cast<size_t>(kMaxMaterials))
    return Error{"a stroke's materials must be a list of 1 to 64"};
  materials.clear();
  for (const Json& item : json) {
    if (!item.is_object()) return Error{"a material must be a JSON object"};
    Material& m = materials.emplace_back();
    if (Status read = fields_from_json(item, "a material", m); !read) return read;
    // Older documents do not have densities.
    if (const Material* known = known_material(m.name); known && !item.contains("density_kg_m3"))
      m.density_kg_m3 = known->density_kg_m3;
    if (const char* fault = fault_of(m)) return Error{fault};
  }
  return Ok{};
}

Status read_symmetry(const Json& json, Symmetry& symmetry) {
  const Error none{
      "a stroke's symmetry must have planes (three times true or false) and centre_mm"};
  const Json planes = json.is_object() ? json.value("planes", Json()) : Json();
  if (!planes.is_array() || planes.size() != 3) return none;
  for (size_t i = 0; i < 3; i++) {
    if (!planes[i].is_boolean()) return none;
    symmetry.planes[i] = planes[i].get<bool>();
  }
  if (!read_vec(json.value("centre_mm", Json()), symmetry.centre_mm)) return none;
  if (json.contains("fold")) {
    Fields f{json};
    std::string axis;
    f.get("fold", symmetry.fold, 1, kMaxFold);
    f.get("axis", axis);
    const auto named_axis = value_of<Axis>(axis);
    if (!f.wrong.empty()) return Error{"a stroke's symmetry: it " + f.wrong};
    if (!named_axis) return Error{"a symmetry's axis must be x, y or z"};
    symmetry.axis = *named_axis;
  }
  return check_symmetry(symmetry);
}

Status read_second(const Json& json, StrokeSettings& s) {
  if (!json.is_object()) return Error{"a stroke's second hand must be a JSON object"};
  StrokeHand hand;
  Fields fields{json};
  std::string mode;
  int material = 0;
  fields.get("mode", mode);
  fields.get("material", material, 0, static_cast<int>(s.materials.size()) - 1);
  const Json *tool = fields.find("tool"), *force = fields.find("force");
  if (!fields.wrong.empty()) return Error{"a stroke's second hand: it " + fields.wrong};
  const std::optional<Mode> known = value_of<Mode>(mode);
  if (!known || *known == Mode::off)
    return Error{"a second hand can cut, deposit or touch, but not '" + sanitize_message(mode) +
                 "'"};
  if (const Status fine = check_modes(s.mode, known, false); !fine) return Error{fine.error()};
  if (!tool->is_object() || !force->is_object())
    return Error{"a second hand's tool and force must be JSON objects"};
  Result<Tool> read = tool_of(*tool);
  if (!read) return Error{read.error()};
  hand.tool = std::move(read).value();
  hand.mode = *known;
  hand.material = static_cast<uint8_t>(material);
  if (Status computed = read_force(*force, s.rate_hz, hand.force); !computed) return computed;
  s.second = std::move(hand);
  return Ok{};
}

Json json_of(const Index3& nodes) { return {nodes[0], nodes[1], nodes[2]}; }

// Reads how far the lattice had grown before a stroke.
Status read_growth(const Json& json, StrokeSettings& s) {
  if (!json.is_object()) return Error{"a stroke's growth of the lattice must be a JSON object"};
  Vec3 below = Vec3::Zero(), above = Vec3::Zero();
  Fields fields{json};
  fields.get("below", below);
  fields.get("above", above);
  for (int i = 0; i < 3; i++) {
    const bool good = below[i] >= 0 && below[i] <= kMaxNodesPerAxis && above[i] >= 0 &&
                      above[i] <= kMaxNodesPerAxis;
    if (!good || std::fmod(below[i], kTileSide) != 0 || std::floor(above[i]) != above[i])
      return Error{"a stroke's growth of the lattice must be whole numbers of nodes"};
    s.grown_below[i] = static_cast<int>(below[i]);
    s.grown_above[i] = static_cast<int>(above[i]);
  }
  return fields.wrong.empty()
             ? Status(Ok{})
             : Status(Error{"a stroke's growth of the lattice: it " + fields.wrong});
}

// True for a finite position with a rotation.
bool is_pose(const Pose& pose) {
  return pose.tip.allFinite() && pose.frame.allFinite() &&
         (pose.frame * pose.frame.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-6;
}

}  // namespace

std::string tool_to_json(const Tool& tool) { return json_of(tool).dump(); }

Result<Tool> tool_from_json(const std::string& text) {
  const Json json = parse_json(text);
  if (!json.is_object()) return Error{"a tool must be a JSON object"};
  return tool_of(json);
}

std::string settings_to_json(const StrokeSettings& s) {
  Json json{{"tool", json_of(s.tool)},
            {"mode", name_of(s.mode)},
            {"material", s.material},
            {"rate_hz", s.rate_hz}};
  json["force"] = json_of(s.force);
  if (reshapes(s.mode)) json["brush"] = json_of(s.brush, s.mode);
  if (s.body != 1) json["body"] = s.body;
  if (!s.device.empty()) json["device"] = s.device;
  if (!s.program.empty()) json["program"] = s.program;
  if (s.grows) json["grows"] = true;
  if ((s.grown_below != 0).any() || (s.grown_above != 0).any())
    json["grown"] = {{"below", json_of(s.grown_below)}, {"above", json_of(s.grown_above)}};
  if (s.crumbs != Crumbs::stay) json["crumbs"] = name_of(s.crumbs);
  if (s.second)
    json["second"] = {{"tool", json_of(s.second->tool)},
                      {"mode", name_of(s.second->mode)},
                      {"material", s.second->material},
                      {"force", json_of(s.second->force)}};
  if (s.symmetry.any())
    json["symmetry"] = {{"planes", s.symmetry.planes}, {"centre_mm", vec(s.symmetry.centre_mm)}};
  if (s.symmetry.fold > 1) {
    json["symmetry"]["fold"] = s.symmetry.fold;
    json["symmetry"]["axis"] = name_of(s.symmetry.axis);
  }
  json["materials"] = json_of(s.materials);
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string materials_to_json(const std::vector<Material>& materials) {
  return json_of(materials).dump(-1, ' ', false, Json::error_handler_t::replace);
}

Result<std::vector<Material>> materials_from_json(const std::string& text) {
  std::vector<Material> materials;
  if (const Status read = read_materials(parse_json(text), materials); !read)
    return Error{read.error()};
  return materials;
}

Result<StrokeSettings> settings_from_json(const std::string& text) {
  const Json json = parse_json(text);
  if (!json.is_object()) return Error{"a stroke's settings must be a JSON object"};
  StrokeSettings s;
  Fields fields{json};
  if (const Json* tool = fields.find("tool")) {
    if (!tool->is_object()) return Error{"a stroke's tool must be a JSON object"};
    Result<Tool> read = tool_of(*tool);
    if (!read) return Error{read.error()};
    s.tool = std::move(read).value();
  }
  std::string mode;
  fields.get("mode", mode);
  const std::optional<Mode> known = value_of<Mode>(mode);
  if (!known) return Error{"there is no mode '" + sanitize_message(mode) + "'"};
  s.mode = *known;
  if (json.contains("device")) fields.get("device", s.device);
  if (json.contains("program")) fields.get("program", s.program);
  s.grows = json.value("grows", Json()) == Json(true);
  if (json.contains("grown"))
    if (const Status read = read_growth(json["grown"], s); !read) return Error{read.error()};
  fields.get("rate_hz", s.rate_hz);
  if (!(s.rate_hz > 0)) return Error{"a stroke's rate_hz is not positive"};
  if (const Json* force = fields.find("force"); force && force->is_object())
    if (const Status read = read_force(*force, s.rate_hz, s.force); !read)
      return Error{read.error()};
  if (const auto symmetry = json.find("symmetry"); symmetry != json.end())
    if (const Status read = read_symmetry(*symmetry, s.symmetry); !read) return Error{read.error()};
  if (reshapes(s.mode)) {
    const Json* brush = fields.find("brush");
    if (!brush || !brush->is_object()) return Error{"a stroke that reshapes has no brush"};
    if (const Status read = read_brush(*brush, s.brush); !read) return Error{read.error()};
    if (const Status fits = check_brush_of(s.mode, s.brush); !fits) return Error{fits.error()};
  }
  if (const Json* materials = fields.find("materials"))
    if (const Status read = read_materials(*materials, s.materials); !read)
      return Error{read.error()};
  int material = 0;
  fields.get("material", material, 0, static_cast<int>(s.materials.size()) - 1);
  s.material = static_cast<uint8_t>(material);
  if (json.contains("body")) fields.get("body", s.body, 1, std::numeric_limits<int>::max());
  if (json.contains("crumbs")) {
    std::string crumbs;
    fields.get("crumbs", crumbs);
    const auto rule = value_of<Crumbs>(crumbs);
    if (!rule) return Error{"there is no rule for crumbs '" + sanitize_message(crumbs) + "'"};
    s.crumbs = *rule;
  }
  if (json.contains("second"))
    if (const Status read = read_second(json["second"], s); !read) return Error{read.error()};
  if (!fields.wrong.empty()) return Error{"a stroke's settings: it " + fields.wrong};
  return s;
}

std::string lattice_to_json(const Lattice& lattice) {
  return Json{{"nodes", {lattice.nodes[0], lattice.nodes[1], lattice.nodes[2]}},
              {"origin_mm", vec(lattice.origin_mm)},
              {"pitch_mm", lattice.pitch_mm}}
      .dump();
}

Result<Lattice> lattice_from_json(const std::string& text) {
  const Json json = parse_json(text);
  const Error none{"its lattice (pitch, origin, size) is missing or invalid"};
  if (!json.is_object()) return none;
  Lattice lattice;
  Vec3 nodes = Vec3::Zero();
  Fields fields{json};
  fields.get("nodes", nodes);
  fields.get("origin_mm", lattice.origin_mm);
  fields.get("pitch_mm", lattice.pitch_mm);
  if (!fields.wrong.empty() || !(lattice.pitch_mm > 0) || !(nodes.minCoeff() >= 1) ||
      !(nodes.maxCoeff() <= kMaxNodesPerAxis))
    return none;
  for (int i = 0; i < 3; i++) lattice.nodes[i] = static_cast<int>(nodes[i]);
  return lattice;
}

std::string box_to_json(const LatticeBox& box) {
  // JSON cannot represent the infinite corners of an empty box. So it is stored as a single point,
  // which no material can have as its box.
  if (box.empty()) return Json{vec(Vec3::Zero()), vec(Vec3::Zero())}.dump();
  return Json{vec(box.units.min), vec(box.units.max)}.dump();
}

Result<LatticeBox> box_from_json(const std::string& text) {
  const Json json = parse_json(text);
  LatticeBox box;
  if (!json.is_array() || json.size() != 2 || !read_vec(json[0], box.units.min) ||
      !read_vec(json[1], box.units.max))
    return Error{"a box must be two corners of three numbers"};
  if (box.units.min.isZero(0) && box.units.max.isZero(0)) return LatticeBox();
  return box;
}

int64_t hash_of(const Bytes& bytes) {
  Hash hash;
  hash.add(bytes.data(), bytes.size());
  return static_cast<int64_t>(hash.value());
}

void add_block(Hash& hash, int64_t sequence, int64_t count, const Bytes& data) {
  hash.add(static_cast<uint64_t>(sequence));
  hash.add(static_cast<uint64_t>(count));
  hash.add(data.data(), data.size());
}

namespace {

// A tick as it is stored. Every kind uses the columns of a move. A put tick stores the columns of
// its frame in the turn and the stretches.
struct TickRow {
  MoveTick move;
  uint8_t flags = 0;
  double line = 0;
};

// Columns after the others: of lines if a flag has kLine, then of pressures if a flag has kPressure.
struct MoreColumns {
  bool lines = false, pressures = false;
  explicit MoreColumns(const Bytes& flags) {
    for (const uint8_t f : flags) {
      lines |= (f & kLine) != 0;
      pressures |= (f & kPressure) != 0;
    }
  }
  int count() const { return int{lines} + int{pressures}; }
};

TickRow row_of(const RecordedTick& tick) {
  TickRow row;
  if (const auto* const move = std::get_if<MoveTick>(&tick.what)) {
    row.move = *move;
    row.flags = static_cast<uint8_t>((move->edits ? kEdits : 0) | (move->computes ? kComputes : 0));
  } else if (const auto* const put = std::get_if<PutTick>(&tick.what)) {
    row.move = {put->pose.tip, put->pose.frame.col(0), false, put->pose.frame.col(1),
                put->pose.frame.col(2)};
    row.flags = kPut;
  } else {
    row.move.tip = std::get<EndTick>(tick.what).tip;
    row.flags = kEnd;
  }
  if (tick.second) row.flags |= kSecond;
  if (tick.line > 0) row.flags |= kLine;
  if (row.move.pressure != 1) row.flags |= kPressure;
  row.line = tick.line;
  return row;
}

std::optional<RecordedTick> tick_of(TickRow row) {
  RecordedTick tick;
  tick.second = (row.flags & kSecond) != 0;
  if (row.flags & kLine) {
    if (!(row.line >= 1 && row.line <= kMaxLine && row.line == std::floor(row.line)))
      return std::nullopt;
    tick.line = static_cast<int>(row.line);
  }
  if (row.flags & kPut) {
    PutTick put;
    put.pose.tip = row.move.tip;
    put.pose.frame << row.move.turn, row.move.stretch_mm, row.move.stretch_rad;
    if ((row.flags & (kEdits | kEnd)) || !is_pose(put.pose)) return std::nullopt;
    tick.what = put;
  } else if (row.flags & kEnd) {
    if ((row.flags & (kEdits | kSecond))) return std::nullopt;
    tick.what = EndTick{row.move.tip};
  } else {
    row.move.edits = (row.flags & kEdits) != 0;
    row.move.computes = (row.flags & kComputes) != 0;
    if (!(row.move.pressure >= 0 && row.move.pressure <= 1)) return std::nullopt;
    tick.what = row.move;
  }
  return tick;
}

}  // namespace

Bytes encode_ticks(const RecordedTick* ticks, size_t count) {
  std::vector<TickRow> rows;
  rows.reserve(count);
  for (size_t i = 0; i < count; i++) rows.push_back(row_of(ticks[i]));
  Bytes raw;
  const auto number = static_cast<uint32_t>(count);
  put(raw, &number, 1);
  Bytes flags;
  for (const TickRow& row : rows) flags.push_back(row.flags);
  raw.insert(raw.end(), flags.begin(), flags.end());
  put_columns(raw, count, kColumns, [&](size_t i, int c) { return column(rows[i].move, c); });
  const MoreColumns more(flags);
  if (more.lines) put_columns(raw, count, 1, [&](size_t i, int) { return rows[i].line; });
  if (more.pressures)
    put_columns(raw, count, 1, [&](size_t i, int) { return rows[i].move.pressure; });
  return compress(raw);
}

Result<std::vector<RecordedTick>> decode_ticks(const Bytes& bytes) {
  const Result<Bytes> raw = decompress(bytes, 4 + kMaxTicks * (1 + 8 * (kColumns + 2)));
  if (!raw) return Error{"a stroke's ticks: the block " + raw.error()};
  Reader reader{raw.value()};
  uint32_t count = 0;
  const Error wrong_length{"a stroke's ticks: the block has the wrong length"};
  if (!reader.take(&count, 1) || raw.value().size() < 4 + size_t{count} * (1 + 8 * kColumns))
    return wrong_length;
  std::vector<TickRow> rows(count);
  Bytes flags(count);
  reader.take(flags.data(), count);
  const MoreColumns more(flags);
  if (raw.value().size() !=
      4 + size_t{count} * (1 + 8 * (kColumns + static_cast<size_t>(more.count()))))
    return wrong_length;
  for (size_t i = 0; i < count; i++) rows[i].flags = flags[i];
  if (!take_columns(reader, count, kColumns,
                    [&](size_t i, int c) -> double& { return column(rows[i].move, c); }) ||
      (more.lines &&
       !take_columns(reader, count, 1, [&](size_t i, int) -> double& { return rows[i].line; })) ||
      (more.pressures && !take_columns(reader, count, 1, [&](size_t i, int) -> double& {
         return rows[i].move.pressure;
       })))
    return Error{"a stroke's ticks contain a value that is not finite"};
  std::vector<RecordedTick> ticks;
  ticks.reserve(count);
  for (const TickRow& row : rows) {
    const std::optional<RecordedTick> tick = tick_of(row);
    if (!tick)
      return Error{"a stroke's ticks contain an invalid pose of the tool, line or pressure"};
    ticks.push_back(*tick);
  }
  return ticks;
}

Bytes encode_forces(const Wrench* computed, size_t count) {
  Bytes raw;
  const auto number = static_cast<uint32_t>(count);
  put(raw, &number, 1);
  put_columns(raw, count, kForceColumns, [&](size_t i, int c) { return column(computed[i], c); });
  return compress(raw);
}

Result<std::vector<Wrench>> decode_forces(const Bytes& bytes) {
  const Result<Bytes> raw = decompress(bytes, 4 + kMaxTicks * 8 * kForceColumns);
  if (!raw) return Error{"a stroke's forces: the block " + raw.error()};
  Reader reader{raw.value()};
  uint32_t count = 0;
  if (!reader.take(&count, 1) || raw.value().size() != 4 + size_t{count} * 8 * kForceColumns)
    return Error{"a stroke's forces: the block has the wrong length"};
  std::vector<Wrench> computed(count);
  if (!take_columns(reader, count, kForceColumns,
                    [&](size_t i, int c) -> double& { return column(computed[i], c); }))
    return Error{"a stroke's forces contain a value that is not finite"};
  return computed;
}

Bytes encode_pose(const Pose& pose) {
  Bytes bytes;
  put(bytes, pose.tip.data(), 3);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) put(bytes, &pose.frame(i, j), 1);
  return bytes;
}

Result<Pose> decode_pose(const Bytes& bytes) {
  Pose pose;
  Reader reader{bytes};
  bool good = reader.take(pose.tip.data(), 3);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) good = good && reader.take(&pose.frame(i, j), 1);
  if (!good || !reader.done() || !is_pose(pose))
    return Error{"a stroke's first pose must be a position and a rotation"};
  return pose;
}

Bytes encode_tile(const Tile& tile) {
  Bytes raw;
  uint32_t planes = 0;
  for (const Plane* p = tile.empty ? nullptr : &tile.first; p; p = p->next) planes++;
  put(raw, &planes, 1);
  for (const Plane* p = tile.empty ? nullptr : &tile.first; p; p = p->next) {
    // Slots without a span may contain anything. They are cleared, so that equal tiles have equal
    // bytes.
    Plane clean = *p;
    for (int i = 0; i < kTileRays; i++)
      if (p->empty_at(i)) {
        clean.in[i] = kFar;
        clean.out[i] = -kFar;
        clean.normal_in[i] = clean.normal_out[i] = 0;
        clean.material[i] = 0;
      }
    put(raw, clean.in, kTileRays);
    put(raw, clean.out, kTileRays);
    put(raw, clean.normal_in, kTileRays);
    put(raw, clean.normal_out, kTileRays);
    put(raw, clean.material, kTileRays);
    const uint8_t painted = p->paint != nullptr;
    raw.push_back(painted);
    if (painted) {
      put(raw, p->paint->in, kTileRays);
      put(raw, p->paint->out, kTileRays);
    }
  }
  return compress(raw);
}

Status decode_tile(const Bytes& bytes, Field& field, int tu, int tv) {
  const Result<Bytes> raw = decompress(bytes, 4 + kMaxPlanes * (kTileRays * 25 + 1));
  if (!raw) return Error{"a tile " + raw.error()};
  Reader reader{raw.value()};
  uint32_t planes = 0;
  if (!reader.take(&planes, 1) || planes > kMaxPlanes) return Error{"a tile has the wrong length"};
  field.clear_tile(tu, tv);
  if (planes == 0) return Ok{};
  Tile& tile = field.writable(tu, tv);
  const auto deepest = static_cast<float>(field.depth_end());
  float last[kTileRays];
  std::fill_n(last, kTileRays, static_cast<float>(field.depth_begin()));
  bool ended[kTileRays] = {};
  int material = -1;
  bool any = false;
  Plane* plane = &tile.first;
  for (uint32_t k = 0; k < planes; k++) {
    if (k > 0) plane = &field.next_plane(*plane);
    uint8_t painted = 0;
    bool good = reader.take(plane->in, kTileRays) && reader.take(plane->out, kTileRays) &&
                reader.take(plane->normal_in, kTileRays) &&
                reader.take(plane->normal_out, kTileRays) &&
                reader.take(plane->material, kTileRays) && reader.take(&painted, 1);
    if (good && painted) {
      PaintPlane& paint = field.paint_of(*plane);
      good = reader.take(paint.in, kTileRays) && reader.take(paint.out, kTileRays);
    }
    if (!good) {
      field.clear_tile(tu, tv);
      return Error{"a tile is truncated"};
    }
    plane->near = kFar;
    plane->far = -kFar;
    plane->tight = true;
    for (int j = 0; j < kTileRays; j++) {
      const float in = plane->in[j], out = plane->out[j];
      if (plane->empty_at(j)) {
        good = good && in == kFar && out == -kFar;
        ended[j] = true;
        continue;
      }
      // Spans must be sorted, disjoint, inside the lattice, and on rays that exist.
      good = good && !ended[j] && in >= last[j] && out <= deepest &&
             plane->material[j] < kMaxMaterials &&
             field.has_ray(tu * kTileSide + j % kTileSide, tv * kTileSide + j / kTileSide);
      last[j] = out;
      plane->include(in, out);
      material =
          material < 0 || material == plane->material[j] ? plane->material[j] : int{kMixedMaterial};
      any = true;
    }
    if (!good) {
      field.clear_tile(tu, tv);
      return Error{"a tile contains invalid spans"};
    }
  }
  if (!reader.done() || !any) {
    field.clear_tile(tu, tv);
    return Error{"a tile has the wrong length"};
  }
  tile.material = static_cast<uint8_t>(material);
  tile.empty = false;
  return Ok{};
}

}  // namespace kibori
