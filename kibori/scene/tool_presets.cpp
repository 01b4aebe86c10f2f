// SPDX-License-Identifier: MIT
#include <kibori/scene/tool_presets.h>

#include <algorithm>
#include <vector>

// Sources of the sizes
//
// Dental burs: shapes and diameters of ISO 6360. The names have US numbers. A round bur is a ball.
//   A straight fissure bur is a flat end mill. A tapered one and a pear are tapered ball noses.
// Temporal bone: the usual set of cutting and diamond burrs of otologic drills, 0.6 to 6 mm.
// Bone gouges and chisels: widths of Stacke's gouge and of straight osteotomes.
// Carving: the sweeps of the Sheffield list, widths in mm.
namespace kibori {

std::span<const ToolPreset> tool_presets() {
  static const std::vector<ToolPreset> presets{
      {"round bur 1/2", "opens pits and fissures: enamel, dentine", BallTool{0.3}},
      {"round bur 2", "removes caries: dentine", BallTool{0.5}},
      {"round bur 4", "removes caries: dentine", BallTool{0.7}},
      {"round bur 8", "removes caries, trims acrylic: dentine, acrylic", BallTool{1.15}},
      {"fissure bur 57", "walls of a cavity: enamel, dentine", Flat{0.5, 4}},
      {"fissure bur 700", "walls that converge: enamel, dentine", TaperedBall{0.35, 8, 0.6, 4}},
      {"pear bur 330", "first opening of a cavity: enamel, dentine", TaperedBall{0.3, 20, 0.4, 2}},
      {"cutting burr 6", "cortical bone of the mastoid", BallTool{3}},
      {"cutting burr 4", "mastoid cells: cortical bone, trabecular bone", BallTool{2}},
      {"diamond burr 3", "next to the facial nerve: cortical bone", BallTool{1.5}},
      {"diamond burr 1", "facial recess, cochlea: cortical bone", BallTool{0.5}},
      {"diamond burr 0.6", "stapes: cortical bone", BallTool{0.3}},
      {"bone gouge 3", "thin shells of the mastoid: cortical bone", Gouge{8, 3, 0.6, 20}},
      {"bone gouge 6", "cancellous bone: trabecular bone", Gouge{7, 6, 0.8, 25}},
      {"osteotome 6", "splits bone: cortical bone", Chisel{6, 15, 1.5, 30}},
      {"osteotome 10", "splits bone: cortical bone, trabecular bone", Chisel{10, 15, 2, 30}},
      {"gouge 3/20", "smooths wide hollows: woods", Gouge{3, 20, 1.5, 60}},
      {"gouge 7/10", "bowls and folds: woods", Gouge{7, 10, 1.5, 60}},
      {"gouge 9/16", "roughs out: woods", Gouge{9, 16, 2, 60}},
      {"gouge 11/3", "veins: woods", Gouge{11, 3, 1, 60}},
      {"v-tool 6", "lines and letters: woods", Vee{60, 6, 1.2, 60}},
      {"chisel 12", "flat ground, letters: woods", Chisel{12, 25, 3, 60}},
  };
  return presets;
}

const ToolPreset* find_tool_preset(std::string_view name) {
  const auto all = tool_presets();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const ToolPreset& p) { return p.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace kibori
