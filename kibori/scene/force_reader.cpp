// SPDX-License-Identifier: MIT
// [force] and [[material]] of a scene.
#include <kibori/scene/scene_reader.h>

#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace {

// Whether a force for each point is given, [force] or a material, which only `paper` has.
bool gives_kf(const TableReader& root) {
  const auto has_kf = [](const toml::node* node) {
    return node && node->is_table() && node->as_table()->contains("kf");
  };
  bool gives = has_kf(root.find("force"));
  const toml::node* const node = root.find("material");
  if (const toml::array* const materials = node ? node->as_array() : nullptr)
    for (const toml::node& material : *materials) gives |= has_kf(&material);
  return gives;
}

void read_spring(const TableReader& force, SeriesSpring& spring) {
  if (force.has("strength")) force.positive("strength");
  force.fields(spring);
  // A hand that is only strong is as stiff as a pointer's, unless the scene says otherwise.
  if (force.has("strength") && !force.has("stiffness"))
    spring.stiffness_n_mm = spring.strength_n / kHandGiveMm;
}

void read_material(SceneReader& reader, const TableReader& t) {
  t.only(TableReader::keys_of<Material>());
  Material material = reader.default_material(t.text("name"));
  for (const Material& other : reader.scene.materials)
    if (other.name == material.name) t.fail("material \"" + material.name + "\" is defined twice");
  // A u that is given alone is that of all directions and places.
  if (t.has("u")) material.u_along = material.ring = 0;
  t.fields(material);
  if (material.ring > kMaxRing)
    t.fail("ring", t.full("ring must not exceed 5: early wood would not resist at all"));
  reader.add_material(t.line(), material);
}

}  // namespace

void read_force(SceneReader& reader, const TableReader& root) {
  auto& [law, spring] = reader.scene.force;
  law.model = gives_kf(root) ? ForceModel::paper : ForceModel::energy;
  const std::optional<TableReader> force = root.section("force", false);
  if (!force) return;
  const std::vector<std::string> of_spring = TableReader::keys_of<SeriesSpring>();
  std::vector<std::string> keys{"model", "kf", "u", "dof"};
  keys.insert(keys.end(), of_spring.begin(), of_spring.end());
  keys.emplace_back("powered");
  force->only(keys);
  force->choice("model", law.model, R"("paper", "energy" or "series")");
  const bool series = reader.scene.force.series();
  for (const std::string& key : of_spring)
    if (force->has(key) && !series)
      force->fail(key, force->full(key) + " is of model = \"series\"");
  if (series) read_spring(*force, spring);
  if (const toml::node* powered = force->find("powered")) {
    const bool press = powered->value<std::string>() == "press";
    if (!powered->is_boolean() && !press)
      force->fail("powered", "[force] powered must be true, false or \"press\"");
    if (press || powered->value_or(false))
      law.hand_share = spring.hand_share = press ? kPressShare : kPoweredShare;
  }
  if (force->has("kf")) force->at_least_zero("kf", reader.kf.emplace());
  if (force->has("u")) force->at_least_zero("u", reader.u.emplace());
  const double dof = force->number_or("dof", 5);
  if (dof != 5 && dof != 6) force->fail("dof", "[force] dof must be 5 or 6");
  law.dof = dof == 6 ? 6 : 5;
}

void read_materials(SceneReader& reader, const TableReader& root) {
  root.for_tables("material", "materials are written as [[material]] tables",
                  [&](const TableReader& t) { read_material(reader, t); });
}

}  // namespace kibori
