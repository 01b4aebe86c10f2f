// SPDX-License-Identifier: MIT
#include <kibori/scene/scene_reader.h>

#include <kibori/haptics/materials.h>

namespace kibori {

std::filesystem::path SceneReader::file(const TableReader& t, std::string_view key) {
  const std::string name = t.text(key);
  if (folder) return scene.files.emplace_back(*folder / name);
  t.fail(key, std::string(key) +
                  " names a file, but this scene must not use files; carve it with 'kibori carve'");
  return {};
}

Material SceneReader::default_material(const std::string& name) const {
  Material material;
  if (const Material* known = known_material(name)) material = *known;
  material.name = name;
  if (kf) material.kf = *kf;
  if (u) set_isotropic(material, *u);
  return material;
}

uint8_t SceneReader::add_material(int line, const Material& material) {
  if (scene.materials.size() >= kMaxMaterials)
    error.report(line, "a scene may have at most " + std::to_string(kMaxMaterials) +
                           " materials; use fewer");
  else
    scene.materials.push_back(material);
  return static_cast<uint8_t>(scene.materials.size() - 1);
}

uint8_t SceneReader::material(int line, const std::string& name) {
  std::vector<std::string> names;
  for (size_t i = 0; i < scene.materials.size(); i++) {
    if (scene.materials[i].name == name) return static_cast<uint8_t>(i);
    names.push_back(scene.materials[i].name);
  }
  if (known_material(name)) return add_material(line, default_material(name));
  for (const Material& known : known_materials()) names.push_back(known.name);
  error.report(line, "unknown material \"" + name + "\"; did you mean \"" + nearest(name, names) +
                         "\", or is a [[material]] table missing?");
  return 0;
}

}  // namespace kibori
