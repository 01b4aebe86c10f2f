// SPDX-License-Identifier: MIT
#include <kibori/scene/scene.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <numbers>
#include <string_view>

#include <toml++/toml.h>

#include <kibori/base/file.h>
#include <kibori/scene/stamp.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/haptics/materials.h>
#include <kibori/motion/reshape_stroke.h>

namespace kibori {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
// What says of a mesh tool which mesh it is.
constexpr std::array kStampKeys{"file", "text",  "picture", "font",
                                "size", "width", "depth",   "invert"};

// Levenshtein distance, for "did you mean".
size_t distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); j++) row[j] = j;
  for (size_t i = 1; i <= a.size(); i++) {
    size_t diagonal = row[0]++;
    for (size_t j = 1; j <= b.size(); j++) {
      const size_t next =
          std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1] ? 1u : 0u)});
      diagonal = std::exchange(row[j], next);
    }
  }
  return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = static_cast<size_t>(-1);
  for (const std::string& k : known)
    if (const size_t d = distance(word, k); d < best_distance) {
      best_distance = d;
      best = k;
    }
  return best;
}

std::vector<std::string> strings(const auto& names) { return {names.begin(), names.end()}; }

// Reads one scene; the first error stops it.
class Reader {
 public:
  Reader(std::string name, std::optional<std::filesystem::path> folder)
      : folder_(std::move(folder)) {
    scene_.file = std::move(name);
  }

  Result<Scene> read(const toml::table& root) {
    only(root, "",
         {"schema", "stock", "material", "tool", "force", "motion", "symmetry", "move", "crumbs",
          "cutter", "no_go", "spline", "layer"});
    if (root.contains("schema") && number(root, "", "schema") != 1)
      fail(root.get("schema"), "schema must be 1; a newer scene needs a newer kibori");
    read_force(root);
    read_materials(root);
    read_stock(root);
    for_tables(root, "layer", "what of the stock is of another material is",
               [&](const toml::table& t) { read_layer(t); });
    read_motion(root);
    read_moves(root);
    read_symmetry(root);
    read_bodies(root);
    if (!error_.empty()) return Error{error_};
    return std::move(scene_);
  }

 private:
  // Empty where there may be none.
  std::filesystem::path file(const toml::table& t, std::string_view section, const char* key) {
    const std::string name = text(t, section, key);
    if (folder_) return scene_.files.emplace_back(*folder_ / name);
    fail(t.get(key),
         std::string(key) +
             " names a file, and this scene came without any; carve it with 'kibori carve'");
    return {};
  }
  void fail(const toml::node* where, const std::string& what) {
    fail(where ? line_of(*where) : 0, what);
  }
  void fail(int line, const std::string& what) {
    if (error_.empty())
      error_ = sanitize_message(scene_.file + (line > 0 ? ":" + std::to_string(line) : "") + ": " +
                                what);
  }
  static int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }
  static std::string full(std::string_view table, std::string_view key) {
    return table.empty() ? std::string(key) : "[" + std::string(table) + "] " + std::string(key);
  }

  void only(const toml::table& table, std::string_view name,
            const std::vector<std::string>& known) {
    for (const auto& [key, node] : table)
      if (std::find(known.begin(), known.end(), key.str()) == known.end())
        fail(static_cast<int>(key.source().begin.line),
             "unknown key '" + std::string(key.str()) + "'" +
                 (name.empty() ? "" : " in [" + std::string(name) + "]") + "; did you mean '" +
                 nearest(key.str(), known) + "'?");
  }

  double as_number(const toml::node* node, const std::string& what) {
    const auto value = node->is_number() ? node->value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      fail(node, what + " must be a finite number");
      return 1;
    }
    return *value;
  }
  // A number that must be there.
  double number(const toml::table& table, std::string_view name, std::string_view key) {
    const toml::node* node = table.get(key);
    if (!node) {
      fail(&table, full(name, key) + " is missing");
      return 1;
    }
    return as_number(node, full(name, key));
  }
  double number_or(const toml::table& table, std::string_view name, std::string_view key,
                   double otherwise) {
    return table.contains(key) ? number(table, name, key) : otherwise;
  }
  double positive(const toml::table& table, std::string_view name, std::string_view key) {
    const double value = number(table, name, key);
    if (!(value > 0)) fail(table.get(key), full(name, key) + " must be greater than 0");
    return value;
  }
  void at_least_zero(const toml::table& table, std::string_view name, std::string_view key,
                     double& value) {
    if (!table.contains(key)) return;
    value = number(table, name, key);
    if (!(value >= 0)) fail(table.get(key), full(name, key) + " must not be negative");
  }
  std::string text(const toml::table& table, std::string_view name, std::string_view key) {
    const toml::node* node = table.get(key);
    if (!node) {
      fail(&table, full(name, key) + " is missing");
      return {};
    }
    const auto value = node->value<std::string>();
    if (!node->is_string() || !value) {
      fail(node, full(name, key) + " must be a string");
      return {};
    }
    return *value;
  }
  std::vector<double> numbers(const toml::table& table, std::string_view name, std::string_view key,
                              size_t count) {
    const toml::node* node = table.get(key);
    const toml::array* array = node ? node->as_array() : nullptr;
    if (!array || array->size() != count) {
      fail(node ? node : static_cast<const toml::node*>(&table),
           full(name, key) + " must be a list of " + std::to_string(count) + " numbers");
      return std::vector<double>(count, 1);
    }
    std::vector<double> result;
    for (const toml::node& element : *array) result.push_back(as_number(&element, full(name, key)));
    return result;
  }
  bool flag_or(const toml::table& table, std::string_view name, std::string_view key,
               bool otherwise) {
    const toml::node* node = table.get(key);
    if (!node) return otherwise;
    if (!node->is_boolean()) fail(node, full(name, key) + " must be true or false");
    return node->value_or(otherwise);
  }
  Vec3 vector(const toml::table& table, std::string_view name, std::string_view key) {
    const auto v = numbers(table, name, key, 3);
    return {v[0], v[1], v[2]};
  }
  const toml::table* table(const toml::table& root, std::string_view key, bool required) {
    const toml::node* node = root.get(key);
    if (!node) {
      if (required) fail(0, "[" + std::string(key) + "] is missing");
      return nullptr;
    }
    if (!node->is_table()) fail(node, "[" + std::string(key) + "] must be a table");
    return node->as_table();
  }

  // Whether a force for each point is given, [force] or a material, which only `paper` has.
  static bool gives_kf(const toml::table& root) {
    const toml::table* const force = root["force"].as_table();
    bool gives = force && force->contains("kf");
    if (const toml::array* const materials = root["material"].as_array())
      for (const toml::node& material : *materials)
        gives |= material.is_table() && material.as_table()->contains("kf");
    return gives;
  }

  void read_force(const toml::table& root) {
    auto& [law, spring] = scene_.force;
    law.model = gives_kf(root) ? ForceModel::paper : ForceModel::energy;
    const toml::table* force = table(root, "force", false);
    if (!force) return;
    only(*force, "force",
         {"model", "kf", "u", "dof", "stiffness", "torsion", "friction", "strength", "powered"});
    if (force->contains("model")) {
      const std::string model = text(*force, "force", "model");
      if (const auto known = value_of<ForceModel>(model))
        law.model = *known;
      else
        fail(force->get("model"), "[force] model must be \"paper\", \"energy\" or \"series\"");
    }
    for (const char* key : {"stiffness", "torsion", "friction", "strength"})
      if (force->contains(key) && !scene_.force.series())
        fail(force->get(key), "[force] " + std::string(key) + " is of model = \"series\"");
    if (scene_.force.series()) {
      if (force->contains("stiffness"))
        spring.stiffness_n_mm = positive(*force, "force", "stiffness");
      at_least_zero(*force, "force", "torsion", spring.torsion_nmm_rad);
      at_least_zero(*force, "force", "friction", spring.friction);
      if (force->contains("strength")) {
        spring.strength_n = positive(*force, "force", "strength");
        // A hand that is only strong is as stiff as a pointer's, unless the scene says otherwise.
        if (!force->contains("stiffness")) spring.stiffness_n_mm = spring.strength_n / kHandGiveMm;
      }
    }
    if (const toml::node* powered = force->get("powered")) {
      const bool press = powered->value<std::string>() == "press";
      if (!powered->is_boolean() && !press)
        fail(powered, "[force] powered must be true, false or \"press\"");
      if (press || powered->value_or(false))
        law.hand_share = spring.hand_share = press ? kPressShare : kPoweredShare;
    }
    if (force->contains("kf")) at_least_zero(*force, "force", "kf", kf_.emplace());
    if (force->contains("u")) at_least_zero(*force, "force", "u", u_.emplace());
    const double dof = number_or(*force, "force", "dof", 5);
    if (dof != 5 && dof != 6) fail(force->get("dof"), "[force] dof must be 5 or 6");
    law.dof = dof == 6 ? 6 : 5;
  }

  void read_materials(const toml::table& root) {
    const toml::node* node = root.get("material");
    if (!node) return;
    const toml::array* list = node->as_array();
    if (!list || !list->is_array_of_tables())
      return fail(node, "materials are written as [[material]] tables");
    for (const toml::node& element : *list) {
      const toml::table& t = *element.as_table();
      only(t, "material",
           {"name", "kf", "u", "c", "yield_n", "color", "plastic", "gc", "u_along", "ring"});
      Material material = defaults(text(t, "material", "name"));
      for (const Material& other : scene_.materials)
        if (other.name == material.name)
          fail(&t, "material \"" + material.name + "\" is defined twice");
      at_least_zero(t, "material", "kf", material.kf);
      at_least_zero(t, "material", "u", material.u);
      at_least_zero(t, "material", "c", material.c);
      at_least_zero(t, "material", "yield_n", material.yield_n);
      at_least_zero(t, "material", "gc", material.gc);
      // A u that is given alone is that of all directions and places.
      if (t.contains("u")) material.u_along = material.ring = 0;
      at_least_zero(t, "material", "u_along", material.u_along);
      at_least_zero(t, "material", "ring", material.ring);
      if (material.ring > kMaxRing)
        fail(t.get("ring"),
             "[material] ring must not exceed 5: early wood would not resist at all");
      if (t.contains("color")) read_color(t, "material", material.color);
      if (const toml::node* plastic = t.get("plastic")) {
        const auto value = plastic->value_exact<bool>();
        if (!value) fail(plastic, "[material] plastic must be true or false");
        material.plastic = value.value_or(false);
      }
      add(&t, material);
    }
  }
  void read_color(const toml::table& t, std::string_view name, std::array<uint8_t, 3>& color) {
    const std::string written = text(t, name, "color");
    unsigned rgb = 0;
    char rest = 0;
    const bool hex = written.size() == 7 &&
                     written.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
    if (!hex || std::sscanf(written.c_str(), "#%6x%c", &rgb, &rest) != 1)
      return fail(t.get("color"), full(name, "color") + " must look like \"#c49a6c\"");
    color = {static_cast<uint8_t>(rgb >> 16), static_cast<uint8_t>(rgb >> 8),
             static_cast<uint8_t>(rgb)};
  }
  // A material by that name as the program knows it, with [force]'s constants in place of its own.
  Material defaults(const std::string& name) {
    Material material;
    for (const Material& known : known_materials())
      if (known.name == name) material = known;
    material.name = name;
    if (kf_) material.kf = *kf_;
    if (u_) {
      material.u = *u_;
      material.u_along = material.ring = 0;  // that of all directions and places
    }
    return material;
  }
  uint8_t add(const toml::node* where, const Material& material) {
    if (scene_.materials.size() >= kMaxMaterials)
      fail(where, "a scene can hold at most " + std::to_string(kMaxMaterials) + " materials");
    else
      scene_.materials.push_back(material);
    return static_cast<uint8_t>(scene_.materials.size() - 1);
  }
  // The index of a material by name, defined in the scene or known to the program.
  uint8_t material(const toml::node* where, const std::string& name) {
    std::vector<std::string> names;
    for (size_t i = 0; i < scene_.materials.size(); i++) {
      if (scene_.materials[i].name == name) return static_cast<uint8_t>(i);
      names.push_back(scene_.materials[i].name);
    }
    for (const Material& known : known_materials()) {
      if (known.name == name) return add(where, defaults(name));
      names.push_back(known.name);
    }
    fail(where, "unknown material \"" + name + "\"; did you mean \"" + nearest(name, names) +
                    "\", or is a [[material]] table missing?");
    return 0;
  }

  void read_stock(const toml::table& root) {
    const toml::table* t = table(root, "stock", true);
    if (!t) return;
    only(*t, "stock",
         {"block", "mesh", "sphere", "cylinder", "relief", "pitch", "material", "fit_mm", "room_mm",
          "width_mm", "height_mm", "base_mm", "invert", "up", "front", "volume", "labels"});
    Stock& stock = scene_.stock;
    stock.line = line_of(*t);
    int kinds = 0;
    for (const char* kind : {"block", "mesh", "sphere", "cylinder", "relief", "volume"})
      kinds += t->contains(kind) ? 1 : 0;
    if (kinds != 1)
      fail(t, "[stock] needs exactly one of block, mesh, sphere, cylinder, relief and volume");
    if (t->contains("block")) {
      stock.kind = Stock::Kind::block;
      stock.size_mm = vector(*t, "stock", "block");
      if (!(stock.size_mm.array() > 0).all())
        fail(t->get("block"), "[stock] block must have three positive sides");
    } else if (t->contains("sphere")) {
      stock.kind = Stock::Kind::sphere;
      stock.size_mm = Vec3::Constant(2 * positive(*t, "stock", "sphere"));
    } else if (t->contains("cylinder")) {
      stock.kind = Stock::Kind::cylinder;
      const auto v = numbers(*t, "stock", "cylinder", 2);
      if (!(v[0] > 0 && v[1] > 0))
        fail(t->get("cylinder"), "[stock] cylinder must be [radius, height], both positive");
      stock.size_mm = {2 * v[0], 2 * v[0], v[1]};
    } else if (t->contains("mesh")) {
      stock.kind = Stock::Kind::mesh;
      stock.mesh_path = file(*t, "stock", "mesh");
    } else if (t->contains("relief")) {
      stock.kind = Stock::Kind::relief;
      stock.mesh_path = file(*t, "stock", "relief");
      stock.width_mm = positive(*t, "stock", "width_mm");
      stock.height_mm = positive(*t, "stock", "height_mm");
      stock.base_mm = positive(*t, "stock", "base_mm");
    } else if (t->contains("volume")) {
      stock.kind = Stock::Kind::volume;
      stock.mesh_path = file(*t, "stock", "volume");
      read_labels(*t, stock);
    }
    if (t->contains("labels") && stock.kind != Stock::Kind::volume)
      fail(t->get("labels"), "[stock] labels goes with volume");
    for (const char* key : {"width_mm", "height_mm", "base_mm"})
      if (t->contains(key) && stock.kind != Stock::Kind::relief)
        fail(t->get(key), std::string("[stock] ") + key + " goes with relief");
    if (t->contains("invert")) {
      if (stock.kind != Stock::Kind::relief)
        fail(t->get("invert"), "[stock] invert goes with relief");
      const auto invert = t->get("invert")->value_exact<bool>();
      if (!invert) fail(t->get("invert"), "[stock] invert must be true or false");
      stock.invert = invert.value_or(false);
    }
    read_orientation(*t, stock);
    stock.pitch_mm = positive(*t, "stock", "pitch");
    if (t->contains("fit_mm")) {
      if (stock.kind != Stock::Kind::mesh) fail(t->get("fit_mm"), "[stock] fit_mm goes with mesh");
      stock.fit_mm = positive(*t, "stock", "fit_mm");
    }
    if (t->contains("room_mm")) at_least_zero(*t, "stock", "room_mm", stock.room_mm.emplace());
    if (stock.kind == Stock::Kind::volume && !stock.labels.empty())
      stock.material = stock.labels.begin()->second;
    if (t->contains("material"))
      stock.material = material(t->get("material"), text(*t, "stock", "material"));
    else if (scene_.materials.empty())
      add(t, defaults("material"));
  }

  // Which material the voxels of each label are of: labels = { 1 = "enamel", 2 = "dentine" }.
  void read_labels(const toml::table& t, Stock& stock) {
    const toml::node* node = t.get("labels");
    const toml::table* labels = node ? node->as_table() : nullptr;
    if (!labels || labels->empty())
      return fail(
          node ? node : &t,
          "[stock] volume needs the material of each label, as in labels = { 1 = \"oak\", 2 "
          "= \"pine\" }");
    for (const auto& [key, value] : *labels) {
      const std::string label(key.str());
      const auto name = value.value_exact<std::string>();
      int number = 0;
      const auto [end, error] = std::from_chars(label.data(), label.data() + label.size(), number);
      if (error != std::errc() || end != label.data() + label.size() || number < 1 ||
          number > 65535)
        return fail(node, "[stock] labels are numbers from 1 to 65535, not \"" + label + "\"");
      if (!name) return fail(node, "[stock] label " + label + " must be a material's name");
      stock.labels[static_cast<uint16_t>(number)] = material(node, *name);
    }
  }

  void read_orientation(const toml::table& t, Stock& stock) {
    const auto read = [&](const char* key, SignedAxis otherwise) {
      if (!t.contains(key)) return otherwise;
      if (stock.kind != Stock::Kind::mesh)
        fail(t.get(key), std::string("[stock] ") + key + " goes with mesh");
      const auto axis = parse_signed_axis(text(t, "stock", key));
      if (!axis)
        fail(t.get(key), std::string("[stock] ") + key +
                             R"( must be "x", "-x", "y", "-y", "z" or "-z", an axis of the file)");
      return axis.value_or(otherwise);
    };
    stock.orientation = standing(read("up", SignedAxis::plus_z));
    stock.orientation.front = read("front", stock.orientation.front);
    if (is_turn(stock.orientation)) return;
    fail(t.get("front"), "[stock] front must be at right angles to up");
    stock.orientation = {};
  }

  void read_symmetry(const toml::table& root) {
    const toml::table* t = table(root, "symmetry", false);
    if (!t) return;
    only(*t, "symmetry", {"planes", "fold", "axis", "centre"});
    Symmetry& symmetry = scene_.symmetry;
    if (t->contains("planes")) {
      const std::string planes = text(*t, "symmetry", "planes");
      for (const char c : planes) {
        if (const auto axis = value_of<Axis>(std::string_view(&c, 1)))
          symmetry.planes[static_cast<size_t>(*axis)] = true;
        else
          fail(t->get("planes"),
               "[symmetry] planes must be letters of \"xyz\", as in planes = \"xy\": the planes "
               "normal to these axes");
      }
    }
    if (t->contains("fold")) {
      const double fold = number(*t, "symmetry", "fold");
      symmetry.fold = fold >= 1 && fold <= kMaxFold ? static_cast<int>(fold) : 0;
      if (symmetry.fold != fold)
        fail(t->get("fold"),
             "[symmetry] fold must be a whole number from 1 to " + std::to_string(kMaxFold));
    }
    if (t->contains("axis")) {
      const auto axis = value_of<Axis>(text(*t, "symmetry", "axis"));
      if (!axis) fail(t->get("axis"), R"([symmetry] axis must be "x", "y" or "z")");
      symmetry.axis = axis.value_or(Axis::z);
    }
    scene_.symmetry_centred = t->contains("centre");
    if (scene_.symmetry_centred) symmetry.centre_mm = vector(*t, "symmetry", "centre");
    if (const Status fits = check_symmetry(symmetry); !fits) fail(t, "[symmetry] " + fits.error());
  }

  void read_motion(const toml::table& root) {
    const toml::table* t = table(root, "motion", false);
    if (!t) return;
    only(*t, "motion", {"rate_hz"});
    if (t->contains("rate_hz")) scene_.rate_hz = positive(*t, "motion", "rate_hz");
    scene_.force.spring.tick_s = 1 / scene_.rate_hz;
  }

  void read_tool_number(const toml::table& t, std::string_view name, const char* key,
                        double& value) {
    value = positive(t, name, key);
  }
  void read_tool_number(const toml::table& t, std::string_view name, const char* key, Vec3& value) {
    value = vector(t, name, key);
  }

  Tool read_tool(const toml::table& t, std::string_view name, const Tool* inherited) {
    std::string shape;
    if (t.contains("shape")) {
      shape = text(t, name, "shape");
    } else if (inherited) {
      shape = shape_of(*inherited);
    } else {
      fail(&t, full(name, "shape") + " is missing");
      return {};
    }
    const std::optional<Tool> known = default_tool(shape);
    if (!known) {
      fail(t.get("shape"), "unknown tool shape \"" + shape + "\"; did you mean \"" +
                               nearest(shape, strings(kToolShapes)) + "\"?");
      return {};
    }
    // A key left out keeps the value of the tool before, if that has the same shape.
    const bool keep = inherited && inherited->index() == known->index();
    Tool tool = keep ? *inherited : *known;
    const bool is_mesh = std::holds_alternative<MeshTool>(tool);
    std::vector<std::string> keys = {"shape"};
    for_tool_numbers(tool, [&](const char* key, const auto&) { keys.emplace_back(key); });
    if (is_mesh) keys.insert(keys.end(), kStampKeys.begin(), kStampKeys.end());
    only(t, name, keys);
    for_tool_numbers(tool, [&](const char* key, auto& value) {
      if (t.contains(key) || !keep) read_tool_number(t, name, key, value);
    });
    if (is_mesh && (t.contains("file") || t.contains("text") || t.contains("picture") || !keep))
      tool = read_stamp(t, name);
    if (error_.empty())
      if (const Status ok = check_tool(tool); !ok) fail(&t, full(name, ok.error()));
    return tool;
  }

  // A mesh, letters, or a picture.
  Tool read_stamp(const toml::table& t, std::string_view name) {
    const int kinds = int{t.contains("file")} + t.contains("text") + t.contains("picture");
    if (kinds != 1) {
      fail(&t, full(name, "a mesh needs exactly one of file, text and picture"));
      return MeshTool{};
    }
    const auto goes_with = [&](const char* key, const char* what) {
      if (t.contains(key) && !t.contains(what))
        fail(t.get(key), full(name, std::string(key) + " goes with " + what));
    };
    goes_with("font", "text");
    goes_with("size", "text");
    goes_with("invert", "picture");
    if (t.contains("width") && t.contains("text"))
      fail(t.get("width"), full(name, "letters are as wide as their size makes them"));
    if (t.contains("depth") && t.contains("file"))
      fail(t.get("depth"), full(name, "a mesh is as deep as it is"));
    if (!error_.empty()) return MeshTool{};
    const auto given = [&](const char* key, double otherwise) {
      return t.contains(key) ? positive(t, name, key) : otherwise;
    };
    Result<Tool> made = Error{""};
    const char* what = "file";
    if (t.contains("text")) {
      what = "text";
      Lettering letters;
      letters.text = text(t, name, "text");
      if (t.contains("font")) letters.font = text(t, name, "font");
      // Of a file as any other: beside the scene, and only where it may name files.
      if (letters.font.find('/') != std::string::npos)
        letters.font = file(t, name, "font").string();
      if (!error_.empty()) return MeshTool{};
      letters.height_mm = given("size", letters.height_mm);
      letters.depth_mm = given("depth", letters.depth_mm);
      made = text_stamp(letters, scene_.stock.pitch_mm);
    } else if (t.contains("picture")) {
      what = "picture";
      const std::filesystem::path path = file(t, name, "picture");
      PictureStamp size;
      size.width_mm = given("width", size.width_mm);
      size.depth_mm = given("depth", size.depth_mm);
      size.invert = flag_or(t, name, "invert", false);
      if (!path.empty()) made = picture_stamp(path, size, scene_.stock.pitch_mm);
    } else if (const std::filesystem::path path = file(t, name, "file"); !path.empty()) {
      if (t.contains("width")) {
        made = mesh_stamp(path, positive(t, name, "width"));
      } else if (auto mesh = read_mesh(path)) {
        made = Tool(MeshTool{std::make_shared<TriangleMesh>(std::move(mesh).value())});
      } else {
        made = Error{mesh.error()};
      }
    }
    if (made) return std::move(made).value();
    if (error_.empty()) fail(t.get(what), made.error());
    return MeshTool{};
  }

  // Keys left out keep their value of the move before.
  void read_brush(const toml::table& move, Move& of) {
    static const toml::table kNone;
    const toml::node* node = move.get("brush");
    if (node && !node->is_table())
      return fail(node, "[move] brush must be a table, as in brush = { radius = 4 }");
    const toml::table& t = node ? *node->as_table() : kNone;
    Brush& brush = of.brush;
    only(t, "brush",
         {"radius", "strength", "falloff", "sigma", "keep_volume", "plane", "color", "wall",
          "spacing"});
    if (t.contains("radius")) brush.radius_mm = positive(t, "brush", "radius");
    // A strength that was never written is what the mode's own is.
    brush_is_strong_ |= t.contains("strength");
    if (t.contains("strength"))
      brush.strength = number(t, "brush", "strength");
    else if (!brush_is_strong_)
      brush.strength = default_strength(of.mode);
    if (t.contains("color")) read_color(t, "brush", brush.color);
    at_least_zero(t, "brush", "sigma", brush.sigma_mm);
    at_least_zero(t, "brush", "wall", brush.wall_mm);
    if (t.contains("spacing")) brush.spacing = number(t, "brush", "spacing");
    if (t.contains("falloff")) {
      const std::string falloff = text(t, "brush", "falloff");
      if (const auto known = value_of<Falloff>(falloff))
        brush.falloff = *known;
      else
        fail(t.get("falloff"), R"([brush] falloff must be "smooth", "linear" or "constant")");
    }
    if (const toml::node* keeps = t.get("keep_volume")) {
      const auto value = keeps->value_exact<bool>();
      if (!value) fail(keeps, "[brush] keep_volume must be true or false");
      brush.keep_volume = value.value_or(false);
    }
    if (const toml::node* plane = t.get("plane")) {
      const auto known = value_of<FlattenTo>(plane->value_or(std::string()));
      if (const toml::table* set = plane->as_table()) {
        only(*set, "plane", {"point", "normal"});
        brush.plane = {vector(*set, "plane", "point"), vector(*set, "plane", "normal")};
        brush.flatten_to = FlattenTo::plane;
      } else if (known && *known != FlattenTo::plane) {
        brush.flatten_to = *known;
      } else {
        fail(plane,
             "[brush] plane must be \"stroke\", \"dab\", or a table, as in plane = { point = [0, "
             "0, 5], normal = [0, 0, 1] }");
      }
    }
    const Status fine = reshapes(of.mode) ? check_brush_of(of.mode, brush) : check_brush(brush);
    if (!fine) fail(node ? node : static_cast<const toml::node*>(&move), "[brush] " + fine.error());
  }

  // Where a hand's tool goes, and what it does on its way; keys left out keep their value of the
  // move before.
  template <class HandMove>
  void read_hand(const toml::table& t, std::string_view name, bool first, HandMove& hand) {
    if (t.contains("to") || first) hand.to_mm = vector(t, name, "to");
    if (t.contains("axis")) {
      const Vec3 axis = vector(t, name, "axis");
      const double largest = axis.cwiseAbs().maxCoeff();
      if (!(largest > 0)) fail(t.get("axis"), full(name, "axis must not be zero"));
      const Vec3 scaled = axis / largest;
      hand.axis = scaled / std::sqrt(scaled.squaredNorm());
    }
    if (t.contains("roll_deg")) {
      const double roll = number(t, name, "roll_deg");
      if (!(std::abs(roll) <= 3600))
        fail(t.get("roll_deg"), full(name, "roll_deg must lie between -3600 and 3600"));
      hand.roll_rad = roll * kRadPerDeg;
    }
    if (t.contains("mode")) {
      const std::string mode = text(t, name, "mode");
      if (const auto known = value_of<Mode>(mode))
        hand.mode = *known;
      else
        fail(t.get("mode"), "unknown mode \"" + mode + "\"; did you mean \"" +
                                nearest(mode, strings(names_of(Mode{}))) + "\"?");
    }
    if (t.contains("material"))
      hand.material = material(t.get("material"), text(t, name, "material"));
    hand.mode = mode_in(scene_.materials[scene_.stock.material], hand.mode);
    if (const toml::node* tool = t.get("tool")) {
      if (!tool->is_table())
        return fail(tool, full(name, "tool must be a table, as in tool = { ks = 0.2 }"));
      scene_.tools.push_back(read_tool(*tool->as_table(), "tool", &scene_.tools[hand.tool]));
      hand.tool = scene_.tools.size() - 1;
    }
  }

  // The keys of a way that is not the straight one; only those of `lead` and `stamp` are kept for
  // the next move.
  void read_way(const toml::table& t, bool first, Move& move) {
    move.along_mm.clear();
    move.arc.reset();
    move.straight = false;
    if (const toml::node* node = t.get("along")) {
      if (t.contains("to") || t.contains("arc"))
        return fail(node, "[move] goes along its points; leave out to and arc");
      move.along_mm = places(t, "move", "along");
      if (!error_.empty()) return;
      if (move.along_mm.empty()) return fail(node, "[move] along must have a point at least");
      move.to_mm = move.along_mm.back();
    }
    if (const toml::node* straight = t.get("straight")) {
      const auto value = straight->value_exact<bool>();
      if (!value) return fail(straight, "[move] straight must be true or false");
      move.straight = *value;
    }
    if (const toml::node* node = t.get("arc")) {
      if (t.contains("to")) return fail(node, "[move] goes along an arc; leave out to");
      const toml::table* arc = node->as_table();
      if (!arc)
        return fail(
            node,
            "[move] arc must be a table, as in arc = { centre = [20, 20, 15], turn_deg = 90 }");
      only(*arc, "arc", {"centre", "turn_deg"});
      const double turn = number(*arc, "arc", "turn_deg");
      if (!(std::abs(turn) <= 36000 && turn != 0))
        return fail(arc->get("turn_deg"),
                    "[arc] turn_deg must lie between -36000 and 36000, and not be 0");
      move.arc = MoveArc{vector(*arc, "arc", "centre"), turn * kRadPerDeg};
    }
    if (const toml::node* node = t.get("lead")) {
      const auto on = node->value_exact<bool>();
      const toml::table* lead = node->as_table();
      if (on) {
        move.lead.on = *on;
      } else if (lead) {
        only(*lead, "lead", {"entry", "lift"});
        move.lead.on = true;
        at_least_zero(*lead, "lead", "entry", move.lead.entry_mm);
        at_least_zero(*lead, "lead", "lift", move.lead.lift_mm);
      } else {
        return fail(
            node,
            "[move] lead must be true, false, or a table, as in lead = { entry = 5, lift = 3 }");
      }
    }
    if (const toml::node* node = t.get("stamp")) {
      const auto on = node->value_exact<bool>();
      const toml::table* stamp = node->as_table();
      if (!on && !stamp)
        return fail(node,
                    "[move] stamp must be true, false, or a table, as in stamp = { every = 12, "
                    "lift = 3 }");
      move.stamp.on = on.value_or(true);
      if (stamp) {
        only(*stamp, "stamp", {"every", "lift"});
        at_least_zero(*stamp, "stamp", "every", move.stamp.every_mm);
        at_least_zero(*stamp, "stamp", "lift", move.stamp.lift_mm);
      }
    }
    if (move.stamps() && !first && move.stamp.every_mm == 0 && (move.winds() || t.contains("to")))
      return fail(move.line,
                  "[move] stamps once, where it stands; leave out its way, or say how far from one "
                  "place to the next, as in stamp = { every = 12, lift = 3 }");
    if (first && (move.winds() || move.lead.on || move.stamp.on))
      fail(move.line, "[move] the first says where the tool starts; it goes no way yet");
  }

  // The second hand is there from the first move on, or never.
  void read_second(const toml::table& move, bool first, Move& of) {
    const toml::node* node = move.get("second");
    if (node && !node->is_table())
      return fail(node, "[move] second must be a table, as in second = { to = [10, 20, 30] }");
    if (node && !first && !of.second)
      return fail(node,
                  "[move] second: the first move must say where the second hand's tool starts");
    if (node) {
      const toml::table& t = *node->as_table();
      only(t, "second", {"to", "axis", "roll_deg", "mode", "material", "tool"});
      if (first) {
        of.second.emplace();
        of.second->material = scene_.stock.material;
        of.second->tool = of.tool;
      }
      read_hand(t, "second", first, *of.second);
    }
    if (!of.second) return;
    const Mode mode = of.second->mode;
    if (reshapes(mode))
      return fail(node, "[second] mode \"" + std::string(name_of(mode)) +
                            "\" is for the first hand; the second cuts, deposits or touches");
    if (reshapes(of.mode) && (mode == Mode::cut || mode == Mode::deposit))
      fail(of.line, "[move] mode \"" + std::string(name_of(of.mode)) +
                        "\" can't work beside a second hand that cuts or adds; give that mode = "
                        "\"off\"");
  }

  void read_moves(const toml::table& root) {
    if (const toml::table* t = table(root, "tool", true))
      scene_.tools.push_back(read_tool(*t, "tool", nullptr));
    const toml::node* node = root.get("move");
    if (!node)
      return fail(0, "a scene needs [[move]] tables; the first says where the tool starts");
    const toml::array* list = node->as_array();
    if (!list || !list->is_array_of_tables())
      return fail(node, "moves are written as [[move]] tables");
    if (!error_.empty()) return;
    Move move;
    move.material = scene_.stock.material;
    for (const toml::node& element : *list) {
      const toml::table& t = *element.as_table();
      const bool first = scene_.moves.empty();
      only(t, "move",
           {"to", "axis", "roll_deg", "speed", "turn_deg_s", "wait_s", "mode", "material", "label",
            "tool", "brush", "second", "along", "straight", "arc", "lead", "stamp"});
      move.line = line_of(t);
      move.label.clear();
      move.wait_s = 0;
      read_hand(t, "move", first, move);
      read_way(t, first, move);
      if (t.contains("speed")) move.speed_mm_s = positive(t, "move", "speed");
      if (t.contains("turn_deg_s"))
        move.turn_rad_s = positive(t, "move", "turn_deg_s") * kRadPerDeg;
      at_least_zero(t, "move", "wait_s", move.wait_s);
      if (t.contains("brush") || reshapes(move.mode)) read_brush(t, move);
      if (t.contains("label")) move.label = text(t, "move", "label");
      read_second(t, first, move);
      if (!error_.empty()) return;
      // A tool that leads itself, or stamps, to no other place goes in and out where it is.
      const double lift = move.stamps() ? move.stamp.lift_mm : move.lead.lift_mm;
      if (!first && (move.leads() || move.stamps()) && !move.winds())
        move.along_mm = {t.contains("to") ? move.to_mm : Vec3(move.to_mm - lift * move.axis)};
      if (!first) {
        auto plan = plan_move(scene_, scene_.moves.back(), move);
        if (!plan) {
          error_ = plan.error();
          return;
        }
        if (plan.value().way) move.to_mm = plan.value().way->places.back().tip;
      }
      scene_.moves.push_back(move);
    }
    if (scene_.moves.empty()) fail(node, "a scene needs at least one [[move]]");
  }

  void read_bodies(const toml::table& root) {
    if (root.contains("crumbs")) {
      const std::string rule = text(root, "", "crumbs");
      if (const auto known = value_of<Crumbs>(rule))
        scene_.crumbs = *known;
      else
        fail(root.get("crumbs"), "crumbs must be \"sort\", \"stay\", \"fall\" or \"body\"");
    }
    for_tables(root, "cutter", "cutters are", [&](const toml::table& t) { read_cutter(t); });
    for_tables(root, "spline", "splines are", [&](const toml::table& t) { read_spline(t); });
    for_tables(root, "no_go", "what no move may cut is",
               [&](const toml::table& t) { read_no_go(t); });
  }

  // Of [[key]]; up to the first error.
  template <class F>
  void for_tables(const toml::table& root, const char* key, const std::string& what, F&& f) {
    const toml::node* node = root.get(key);
    if (!node) return;
    const toml::array* list = node->as_array();
    if (!list || !list->is_homogeneous(toml::node_type::table))
      return fail(node, what + " written as [[" + key + "]]");
    for (const toml::node& element : *list) {
      f(*element.as_table());
      if (!error_.empty()) return;
    }
  }

  // A shape that stands in the stock: which, and how it stands.
  Tool read_shape(const toml::table& t, std::string_view name) {
    const toml::node* tool = t.get("tool");
    if (tool && tool->is_table()) return read_tool(*tool->as_table(), "tool", nullptr);
    fail(tool ? tool : &t, full(name, "tool must be a table, as in tool = { shape = \"ball\" }"));
    return {};
  }
  Mat3 frame_of(const toml::table& t, std::string_view name) {
    Vec3 axis = Vec3::UnitZ();
    if (t.contains("axis")) axis = vector(t, name, "axis");
    if (!(axis.norm() > 0)) fail(t.get("axis"), full(name, "axis must not be zero"));
    if (!error_.empty()) return Mat3::Identity();
    return frame_from_axis(axis.normalized(), kRadPerDeg * number_or(t, name, "roll_deg", 0));
  }

  void read_layer(const toml::table& t) {
    only(t, "layer", {"tool", "place", "axis", "roll_deg", "material"});
    StockLayer layer;
    layer.line = line_of(t);
    layer.shape = read_shape(t, "layer");
    if (!error_.empty()) return;
    layer.pose = {vector(t, "layer", "place"), frame_of(t, "layer")};
    layer.material = material(t.get("material"), text(t, "layer", "material"));
    if (scene_.stock.layers.size() >= kMaxLayers)
      return fail(&t, "a scene can hold at most " + std::to_string(kMaxLayers) + " layers");
    scene_.stock.layers.push_back(std::move(layer));
  }

  void read_no_go(const toml::table& t) {
    only(t, "no_go", {"tool", "place", "axis", "roll_deg", "way", "name"});
    SceneNoGo made;
    made.line = line_of(t);
    made.tool = read_shape(t, "no_go");
    if (!error_.empty()) return;
    if (t.contains("way")) {
      for (const char* key : {"place", "axis", "roll_deg"})
        if (t.contains(key))
          fail(t.get(key), "[no_go] has " + std::string(key) + " or a way, not both");
      made.way_mm = places(t, "no_go", "way");
    } else {
      made.pose.tip = vector(t, "no_go", "place");
    }
    made.pose.frame = frame_of(t, "no_go");
    if (!error_.empty()) return;
    if (t.contains("name")) made.name = text(t, "no_go", "name");
    if (made.name.size() > 100) fail(t.get("name"), "[no_go] name has at most 100 bytes");
    for (const Move& move : scene_.moves)
      if (reshapes(move.mode))
        return fail(move.line,
                    "[move] mode \"" + std::string(name_of(move.mode)) +
                        "\" can't work beside [[no_go]]; only what cuts, adds or feels can");
    scene_.no_go.push_back(std::move(made));
  }

  // Of a list of places.
  std::vector<Vec3> places(const toml::table& t, std::string_view name, std::string_view key) {
    std::vector<Vec3> all;
    const toml::node* node = t.get(key);
    const toml::array* list = node ? node->as_array() : nullptr;
    if (!list) {
      fail(node ? node : &t, full(name, key) + " must be a list of places [x, y, z]");
      return all;
    }
    for (const toml::node& item : *list) {
      const toml::array* place = item.as_array();
      if (!place || place->size() != 3) {
        fail(&item, full(name, key) + " must be a list of places [x, y, z]");
        return all;
      }
      all.emplace_back();
      for (size_t i = 0; i < 3; i++)
        all.back()[static_cast<int>(i)] = as_number(place->get(i), "a place of " + full(name, key));
    }
    return all;
  }

  void read_spline(const toml::table& t) {
    only(t, "spline",
         {"kind", "points", "closed", "through", "direction", "length", "axis_point", "axis",
          "radius", "mode", "material"});
    SceneSpline made;
    made.line = line_of(t);
    SplineShape& shape = made.shape;
    const std::string kind = text(t, "spline", "kind");
    if (const auto known = value_of<SplineKind>(kind))
      shape.kind = *known;
    else
      fail(t.get("kind"), "[spline] kind must be \"extrude\", \"revolve\" or \"sweep\"");
    shape.curve.points_mm = places(t, "spline", "points");
    shape.curve.closed = flag_or(t, "spline", "closed", false);
    shape.curve.interpolate = flag_or(t, "spline", "through", true);
    const auto of = [&](SplineKind of_kind, std::initializer_list<const char*> keys) {
      for (const char* key : keys)
        if (shape.kind != of_kind && t.contains(key))
          fail(t.get(key),
               full("spline", key) + " is of kind = \"" + std::string(name_of(of_kind)) + "\"");
    };
    of(SplineKind::extrude, {"direction", "length"});
    of(SplineKind::revolve, {"axis_point", "axis"});
    of(SplineKind::sweep, {"radius"});
    if (!error_.empty()) return;
    if (shape.kind == SplineKind::extrude) {
      if (t.contains("direction")) shape.direction = vector(t, "spline", "direction");
      shape.length_mm = positive(t, "spline", "length");
    }
    if (shape.kind == SplineKind::revolve) {
      if (t.contains("axis_point")) shape.axis_point_mm = vector(t, "spline", "axis_point");
      if (t.contains("axis")) shape.axis = vector(t, "spline", "axis");
    }
    if (shape.kind == SplineKind::sweep) shape.radius_mm = positive(t, "spline", "radius");
    if (t.contains("mode")) {
      const std::string mode = text(t, "spline", "mode");
      if (const auto known = value_of<SplineOperation>(mode))
        made.operation = *known;
      else
        fail(t.get("mode"), "[spline] mode must be \"deposit\", \"cut\" or \"intersect\"");
    }
    made.material = scene_.stock.material;
    if (t.contains("material"))
      made.material = material(t.get("material"), text(t, "spline", "material"));
    if (!error_.empty()) return;
    if (const auto fits = make_spline_mesh(shape, scene_.stock.pitch_mm); !fits)
      return fail(made.line, "[spline]: " + fits.error());
    scene_.splines.push_back(std::move(made));
  }

  void read_cutter(const toml::table& t) {
    only(t, "cutter",
         {"point", "normal", "curve", "along", "closed", "smooth", "kerf", "body", "shift", "feed",
          "speed"});
    SceneCutter made;
    made.line = line_of(t);
    Cutter& cutter = made.cutter;
    if (t.contains("curve")) {
      cutter.kind = Cutter::Kind::curve;
      for (const char* key : {"point", "normal"})
        if (t.contains(key)) fail(t.get(key), std::string("[cutter] has a curve, so no ") + key);
      cutter.curve_mm = places(t, "cutter", "curve");
      if (t.contains("along")) cutter.along = vector(t, "cutter", "along");
      cutter.closed = flag_or(t, "cutter", "closed", false);
      cutter.smooth = flag_or(t, "cutter", "smooth", false);
    } else {
      cutter.point_mm = vector(t, "cutter", "point");
      cutter.normal = vector(t, "cutter", "normal");
    }
    at_least_zero(t, "cutter", "kerf", cutter.kerf_mm);
    if (t.contains("body")) made.body = text(t, "cutter", "body");
    if (t.contains("shift")) made.shift_mm = vector(t, "cutter", "shift");
    if (t.contains("feed")) {
      const Vec3 feed = vector(t, "cutter", "feed");
      if (!(feed.norm() > 0)) fail(t.get("feed"), "[cutter] feed must not be zero");
      made.feed = feed.normalized();
      made.speed_mm_s = positive(t, "cutter", "speed");
    } else if (t.contains("speed")) {
      fail(t.get("speed"),
           "[cutter] speed is of its feed; say which way it goes: feed = [x, y, z]");
    }
    if (!error_.empty()) return;
    if (const Status fits = check_cutter(cutter); !fits)
      return fail(made.line, "[cutter]: " + fits.error());
    scene_.cutters.push_back(std::move(made));
  }

  Scene scene_;
  std::optional<std::filesystem::path> folder_;
  std::string error_;
  std::optional<double> kf_, u_;
  bool brush_is_strong_ = false;  // a move has said a brush's strength
};

constexpr int kMaxDepth = 32;  // tables in tables, lists in lists; scenes need four
constexpr uint64_t kMaxSceneBytes = uint64_t{256} << 20;  // some millions of moves

// Before it is parsed: what is parsed, and what frees it again, goes as deep into the stack as
// tables lie in tables. A dotted key is as deep as it has dots.
Status check_depth(std::string_view text, const std::string& name) {
  int line = 1, depth = 0, dots = 0;
  for (size_t i = 0; i < text.size(); i++) {
    const char c = text[i];
    if (c == '\n') line++;
    if (c == '#') {
      while (i + 1 < text.size() && text[i + 1] != '\n') i++;
    } else if (c == '"' || c == '\'') {
      const std::string_view quotes =
          text.substr(i).starts_with(std::string(3, c)) ? text.substr(i, 3) : text.substr(i, 1);
      for (i += quotes.size(); i < text.size() && !text.substr(i).starts_with(quotes); i++) {
        if (text[i] == '\n') {
          line++;
          if (quotes.size() == 1) break;
        }
        if (c == '"' && text[i] == '\\') i++;
      }
      i += quotes.size() - 1;
      if (quotes.size() == 3)  // one or two more belong to the string
        for (int k = 0; k < 2 && i + 1 < text.size() && text[i + 1] == c; k++) i++;
    } else if (c == '[' || c == '{') {
      depth++;
      dots = 0;
    } else if (c == ']' || c == '}') {
      depth--;
      dots = 0;
    } else if (c == '.') {
      dots++;
    } else if (c == ',' || c == '=' || c == '\n') {
      dots = 0;
    }
    if (depth + dots > kMaxDepth)
      return Error{sanitize_message(name + ":" + std::to_string(line) +
                                    ": tables or lists lie more than " + std::to_string(kMaxDepth) +
                                    " deep in each other; no scene needs that")};
  }
  return Ok{};
}

}  // namespace

Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder) {
  if (const Status flat = check_depth(text, name); !flat) return Error{flat.error()};
  try {
    return Reader(name, folder).read(toml::parse(text, name));
  } catch (const toml::parse_error& error) {
    return Error{sanitize_message(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                  std::string(error.description()))};
  }
}

Result<Scene> read_scene(const std::filesystem::path& path) {
  const Result<std::vector<char>> text = read_file(path, kMaxSceneBytes);
  if (!text) return Error{text.error()};
  return parse_scene(std::string(text.value().begin(), text.value().end()), path.string(),
                     path.parent_path());
}

Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to) {
  const auto wrong = [&](const std::string& what) {
    return Error{scene.file + ":" + std::to_string(to.line) + ": " + what};
  };
  MovePlan plan;
  double length = 0, angle = 0;  // the longer of both hands'
  if (to.winds() || to.leads() || to.stamps()) {
    if (to.axis.dot(from.axis) < 1 - 1e-12)
      return wrong(
          "[move] along, arc, lead and stamp need an axis that stays; turn it in a move before");
    Result<MoveWay> way = way_of(from, to, scene.stock.pitch_mm);
    if (!way) return wrong("[move] " + way.error());
    length = way.value().length_mm();
    plan.way = std::move(way).value();
  }
  const auto plan_hand = [&](const auto& a, const auto& b, Vec3& turn_rad) -> Status {
    Vec3 turn = shortest_turn(a.axis, b.axis);
    // The same axis, but for the last bit.
    if (turn.squaredNorm() < kNoTurn * kNoTurn) turn = Vec3::Zero();
    const double roll = b.roll_rad - a.roll_rad;
    if (a.axis.dot(b.axis) < -1 + 1e-9)
      return wrong(
          "[move] axis reverses exactly, so the way round is open; add a move with an axis in "
          "between");
    if (turn.squaredNorm() > 0 && roll != 0)
      return wrong("[move] changes axis and roll_deg together; use two moves");
    turn_rad = roll != 0 ? Vec3(roll * b.axis) : turn;
    if (plan.way && static_cast<const void*>(&a) == &from) return Ok{};
    length = std::max(length, std::sqrt((b.to_mm - a.to_mm).squaredNorm()));
    angle = std::max(angle, std::sqrt(turn_rad.squaredNorm()));
    return Ok{};
  };
  if (const Status fine = plan_hand(from, to, plan.turn_rad); !fine) return Error{fine.error()};
  if (from.second && to.second)
    if (const Status fine = plan_hand(*from.second, *to.second, plan.second_turn_rad); !fine)
      return Error{fine.error()};
  double ticks = 0;
  // A hair less before rounding up: 100 mm at 40 mm/s and 1000 Hz are 2500 ticks, whatever the last
  // bit says.
  const auto whole = [](double x) { return std::max(1.0, std::ceil(x * (1 - 1e-12))); };
  if (length > 0) {
    if (!(to.speed_mm_s > 0)) return wrong("[move] needs a speed (mm/s)");
    ticks = whole(length * scene.rate_hz / to.speed_mm_s);
  } else if (angle > 0) {
    if (!(to.turn_rad_s > 0)) return wrong("[move] turns without travelling and needs turn_deg_s");
    ticks = whole(angle * scene.rate_hz / to.turn_rad_s);
  }
  // Nothing to do but to stand there: a tick all the same, so that a new tool or mode acts.
  if (ticks == 0 && !(to.wait_s > 0)) ticks = 1;
  const double dwell = to.wait_s > 0 ? whole(to.wait_s * scene.rate_hz) : 0;
  if (!(ticks + dwell <= 1e9))
    return wrong("[move] would take more than 10^9 ticks; raise its speed or lower rate_hz");
  plan.ticks = static_cast<int64_t>(ticks);
  plan.dwell_ticks = static_cast<int64_t>(dwell);
  return plan;
}

StrokeSettings stroke_settings(const Scene& scene, const Move& move) {
  StrokeSettings s;
  s.tool = scene.tools[move.tool];
  s.mode = move.mode;
  s.material = move.material;
  s.brush = move.brush;
  s.materials = scene.materials;
  s.force = scene.force;
  s.rate_hz = scene.rate_hz;
  const bool severs = may_sever(move.mode) || (move.both() && may_sever(move.second->mode));
  s.crumbs = severs ? scene.crumbs : Crumbs::stay;
  if (move.both())
    s.second = StrokeHand{scene.tools[move.second->tool], move.second->mode, move.second->material,
                          scene.force};
  return s;
}

}  // namespace kibori
