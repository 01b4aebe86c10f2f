// SPDX-License-Identifier: MIT
// Reads [force] and [[material]] of a scene.
#include <kibori/scene/scene_reader.h>

#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace {

// True if [force] or a material gives kf, the force per point. Only the model `paper` uses it.
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
  // If only a strength is given, the stiffness follows from it, as in spring_of_hand.
  if (force.has("strength") && !force.has("stiffness"))
    spring.stiffness_n_mm = spring.strength_n / kHandGiveMm;
}

void read_material(SceneReader& reader, const TableReader& t) {
  t.only(TableReader::keys_of<Material>());
  if (t.has("log")) t.fail("log", "log belongs to [stock]: all materials of a stock share it");
  Material material = reader.default_material(t.text("name"));
  for (const Material& other : reader.scene.materials)
    if (other.name == material.name) t.fail("material \"" + material.name + "\" is defined twice");
  if (t.has("u") && t.has("k"))
    t.fail("k", t.full("k and u both set the cutting force; give one of them"));
  // `u` and `k` each define the whole cutting force. The values of the built-in material must not
  // remain next to them.
  if (t.has("u") || t.has("k")) set_isotropic(material, 0);
  t.fields(material);
  if (t.has("k")) material.u = mean_cutting_energy(material);
  if (const char* fault = fault_of(material)) t.fail(t.full(fault));
  reader.add_material(t.line(), material);
}

}  // namespace

void read_force(SceneReader& reader, const TableReader& root) {
  auto& [law, spring] = reader.scene.force;
  law.model = gives_kf(root) ? ForceModel::paper : ForceModel::energy;
  const std::optional<TableReader> force = root.section("force", false);
  if (law.model == ForceModel::energy) law.thrust = kSharpThrust;
  if (!force) return;
  const std::vector<std::string> of_spring = TableReader::keys_of<SeriesSpring>();
  std::vector<std::string> keys{"model", "kf", "u", "dof"};
  keys.insert(keys.end(), of_spring.begin(), of_spring.end());
  keys.insert(keys.end(), {"powered", "thrust"});
  force->only(keys);
  force->choice("model", law.model, R"("paper", "energy" or "series")");
  const bool series = reader.scene.force.series();
  for (const std::string& key : of_spring)
    if (force->has(key) && !series)
      force->fail(key, force->full(key) + " needs model = \"series\"");
  if (series) read_spring(*force, spring);
  if (const toml::node* powered = force->find("powered")) {
    const bool press = powered->value<std::string>() == "press";
    if (!powered->is_boolean() && !press)
      force->fail("powered", "[force] powered must be true, false or \"press\"");
    if (press || powered->value_or(false))
      law.hand_share = spring.hand_share = press ? kPressShare : kPoweredShare;
  }
  if (force->has("kf")) force->not_negative("kf", reader.kf.emplace());
  if (force->has("u")) force->not_negative("u", reader.u.emplace());
  law.thrust = law.model == ForceModel::energy ? kSharpThrust : 0;
  if (force->has("thrust")) {
    if (law.model != ForceModel::energy)
      force->fail("thrust", force->full("thrust") + " needs model = \"energy\"");
    force->not_negative("thrust", law.thrust);
    if (law.thrust > kMaxThrust)
      force->fail("thrust", force->full("thrust") + " must not exceed 3");
  }
  const double dof = force->number_or("dof", 5);
  if (dof != 5 && dof != 6) force->fail("dof", "[force] dof must be 5 or 6");
  law.dof = dof == 6 ? 6 : 5;
}

void read_materials(SceneReader& reader, const TableReader& root) {
  root.for_tables("material", "materials are written as [[material]] tables",
                  [&](const TableReader& t) { read_material(reader, t); });
}

}  // namespace kibori
