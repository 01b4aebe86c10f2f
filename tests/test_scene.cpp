// SPDX-License-Identifier: MIT
// Scenes and mesh files: valid files are read, and every malformed one gives a sentence that says
// where.
#include <cstring>
#include <fstream>

#include <gtest/gtest.h>

#include <kibori/base/file.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/report/force_report.h>
#include <kibori/edit/edit.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/formats/png_file.h>
#include <kibori/formats/stl.h>
#include <kibori/measure/mass.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/scene/tool_presets.h>

#include "tests/support.h"

namespace kibori::scene_tests {
namespace {

const std::string kGood = R"([stock]
block = [20, 12, 10]
pitch = 0.5
[tool]
shape = "finger"
ks = 0.4
length = 15
[force]
kf = 0.001
[[move]]
to = [-5, 6, 8]
label = "A"
[[move]]
to = [25, 6, 6]
speed = 40
label = "B"
)";

std::string replaced(const std::string& what, const std::string& with) {
  std::string text = kGood;
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

struct Bad {
  const char* what;
  const char* with;
  const char* expected;  // parts of the message, separated by |
};
void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.with; }

class BadScene : public testing::TestWithParam<Bad> {};

TEST_P(BadScene, GetsOneClearSentence) {
  const Bad& bad = GetParam();
  const auto scene = parse_scene(replaced(bad.what, bad.with), "scene.toml", ".");
  std::string message;
  if (!scene) {
    message = scene.error();
  } else {
    const auto carving = carve(scene.value(), {});
    ASSERT_FALSE(carving) << "accepted: " << bad.with;
    message = carving.error();
  }
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_EQ(message.rfind("scene.toml", 0), 0u) << message;
  std::string rest = bad.expected;
  while (!rest.empty()) {
    const size_t bar = rest.find('|');
    const std::string part = rest.substr(0, bar);
    EXPECT_NE(message.find(part), std::string::npos) << "expected '" << part << "' in: " << message;
    rest = bar == std::string::npos ? "" : rest.substr(bar + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, BadScene,
    testing::Values(
        Bad{"pitch = 0.5", "pitch = 0", ":3:|pitch|greater than 0"},
        Bad{"pitch = 0.5", "pitch = nan", ":3:|finite"},
        Bad{"pitch = 0.5", "pitch = -1", ":3:|pitch"},
        Bad{"pitch = 0.5", "pitch = 1e-9", "pitch|lattice nodes"},
        Bad{"pitch = 0.5", "pitch = \"fine\"", ":3:|number"},
        Bad{"pitch = 0.5", "", "pitch is missing"}, Bad{"ks = 0.4", "ks = -0.4", ":6:|ks"},
        Bad{"ks = 0.4", "ks = inf", ":6:|ks"}, Bad{"ks = 0.4", "kz = 0.4", ":6:|kz|'ks'"},
        Bad{"length = 15", "length = 0", ":7:|length"},
        Bad{"block = [20, 12, 10]", "block = [20, 12]", ":2:|3 numbers"},
        Bad{"block = [20, 12, 10]", "block = [20, 0, 10]", ":2:|positive"},
        Bad{"block = [20, 12, 10]", "block = [20, 12, 10]\nsphere = 4", "exactly one"},
        Bad{"block = [20, 12, 10]", "sphere = 0.01", "no material"},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\nfit_mm = -2", "fit_mm"},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\nx = 1", "x"},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\nup = \"w\"", ":3:|up|\"-x\""},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\nup = 3", ":3:|up|string"},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\nup = \"y\"\nfront = \"-y\"",
            ":4:|front|right angles"},
        Bad{"block = [20, 12, 10]", "mesh = \"nowhere.stl\"\ninvert = true", ":3:|invert|relief"},
        Bad{"block = [20, 12, 10]", "block = [20, 12, 10]\nup = \"y\"", ":3:|up needs mesh"},
        Bad{"shape = \"finger\"", "shape = \"fingr\"", ":5:|finger"},
        Bad{"shape = \"finger\"", "", "shape is missing"}, Bad{"kf = 0.001", "kf = -1", ":9:|kf"},
        Bad{"kf = 0.001", "model = \"spring\"", ":9:|paper"},
        Bad{"kf = 0.001", "dof = 4", ":9:|5 or 6"}, Bad{"kf = 0.001", "thrust = 4", ":9:|thrust|3"},
        Bad{"kf = 0.001", "model = \"series\"\nthrust = 0.3", ":10:|thrust|energy"},
        Bad{"[tool]", "[[material]]\nname = \"ash\"\nk = [1, 2]\n[tool]", ":6:|k|3 numbers"},
        Bad{"[tool]", "[[material]]\nname = \"ash\"\nk = [1, 0, 2]\n[tool]", "k|greater than 0"},
        Bad{"[tool]", "[[material]]\nname = \"ash\"\nk = 1\nu = 2\n[tool]", ":6:|k|u"},
        Bad{"[tool]", "[[material]]\nname = \"ash\"\nk = 1\nm = 1\n[tool]", "m must be less"},
        Bad{"[tool]", "[[material]]\nname = \"ash\"\nu = 1\nm = 0.5\n[tool]", "m needs k"},
        Bad{"[tool]", "[[material]]\nname = \"oak\"\nlog = {}\n[tool]", ":6:|[stock]"},
        Bad{"block = [20, 12, 10]", "block = [20, 12, 10]\nlog = 3", "log|table"},
        Bad{"block = [20, 12, 10]", "block = [20, 12, 10]\nlog = { axis = [1, 0, 0] }", "pith"},
        Bad{"block = [20, 12, 10]", "block = [20, 12, 10]\nlog = { ring = 1 }",
            "unknown key 'ring'"},
        Bad{"kf = 0.001", "dof = 5555555555.5", ":9:|5 or 6"},
        Bad{"to = [25, 6, 6]", "to = [25, nan, 6]", ":14:|finite"},
        Bad{"to = [25, 6, 6]", "too = [25, 6, 6]", ":14:|'to'"},
        Bad{"speed = 40", "", ":13:|speed"}, Bad{"speed = 40", "speed = 0", ":15:|speed"},
        Bad{"speed = 40", "speed = 1e-9", ":13:|ticks"},
        Bad{"speed = 40", "speed = 40\naxis = [0, 0, -1]", ":13:|is reversed"},
        Bad{"speed = 40", "speed = 40\naxis = [0, 0, 0]", "axis|zero"},
        Bad{"speed = 40", "speed = 40\nroll_deg = 1e300", ":16:|roll_deg"},
        Bad{"ks = 0.4\nlength = 15", "ks = 1e-9\nlength = 1e9", "[tool]|smaller"},
        Bad{"to = [25, 6, 6]\nspeed = 40", "to = [1e20, 6, 6]\nspeed = 1e24", ":13:|slower"},
        Bad{"speed = 40", "speed = 40\nmode = \"cutt\"", "cut"},
        Bad{"speed = 40", "speed = 40\nmaterial = \"oka\"", "oak"},
        Bad{"speed = 40", "speed = 40\nmode = \"smoth\"", "smooth"},
        Bad{"speed = 40", "speed = 40\nbrush = 3", ":16:|table"},
        Bad{"speed = 40", "speed = 40\nbrush = { radius = 0 }", ":16:|radius"},
        Bad{"speed = 40", "speed = 40\nbrush = { radios = 1 }", ":16:|'radius'"},
        Bad{"speed = 40", "speed = 40\nmode = \"smooth\"\nbrush = { strength = -1 }",
            ":17:|strength|only inflate"},
        Bad{"speed = 40", "speed = 40\nmode = \"inflate\"\nbrush = { strength = 2 }",
            ":17:|strength"},
        Bad{"speed = 40", "speed = 40\nbrush = { falloff = \"steep\" }", ":16:|falloff|linear"},
        Bad{"speed = 40", "speed = 40\nbrush = { sigma = -1 }", ":16:|sigma"},
        Bad{"speed = 40", "speed = 40\nbrush = { keep_volume = 1 }", ":16:|true or false"},
        Bad{"speed = 40", "speed = 40\nbrush = { spacing = 0 }", ":16:|0.05 to 2"},
        Bad{"speed = 40", "speed = 40\nbrush = { wall = -1 }", ":16:|wall"},
        Bad{"speed = 40", "speed = 40\nbrush = { plane = \"z\" }", ":16:|plane"},
        Bad{"speed = 40", "speed = 40\nbrush = { plane = { point = [0, 0, 1] } }",
            ":16:|normal|3 numbers"},
        Bad{"speed = 40",
            "speed = 40\nbrush = { plane = { point = [0, 0, 1], normal = [0, 0, 0] } }",
            ":16:|normal|not 0"},
        Bad{"to = [25, 6, 6]\nspeed = 40",
            "to = [1e5, 6, 6]\nspeed = 1e9\nmode = \"rasp\"\nbrush = { radius = 1 }",
            ":13:|10000 dabs|slower"},
        Bad{"speed = 40", "speed = 40\ntool = 3", "table"},
        Bad{"speed = 40", "speed = 40\ntool = { radius = 3 }", "radius"},
        Bad{"[tool]", "schema = 2\n[tool]", "schema"}, Bad{"[tool]", "[tol]", "'tol'|'tool'"},
        Bad{"[force]", "[force", ":8:"}, Bad{"[tool]", "[spline]\n[tool]", "[[spline]]"},
        Bad{"[tool]",
            "[[cutter]]\npoint = [9, 0, 0]\nnormal = [1, 0, 0]\nfeed = [0, 0, 0]\nspeed = "
            "1\n[tool]",
            ":7:|zero"},
        Bad{"[tool]", "[[cutter]]\npoint = [9, 0, 0]\nnormal = [1, 0, 0]\nspeed = 1\n[tool]",
            ":7:|feed"},
        Bad{"[tool]", "[[cutter]]\npoint = [9, 0, 0]\nnormal = [1, 0, 0]\nfeed = [0, 0, 1]\n[tool]",
            "speed is missing"},
        Bad{"[tool]", "[[spline]]\n[tool]", "kind is missing"},
        Bad{"[tool]", "[[spline]]\nkind = \"loft\"\n[tool]", ":5:|\"sweep\""},
        Bad{"[tool]", "[[spline]]\nkind = \"sweep\"\nradius = 2\n[tool]", ":4:|points"},
        Bad{"[tool]",
            "[[spline]]\nkind = \"sweep\"\npoints = [[0, 0, 0], [9, 0]]\nradius = 2\n[tool]",
            ":6:|[x, y, z]"},
        Bad{"[tool]", "[[spline]]\nkind = \"sweep\"\npoints = [[0, 0, 0], [9, 0, 0]]\n[tool]",
            "radius is missing"},
        Bad{"[tool]",
            "[[spline]]\nkind = \"sweep\"\npoints = [[0, 0, 0], [9, 0, 0]]\nlength = 2\n[tool]",
            ":7:|length|extrude"},
        Bad{"[tool]",
            "[[spline]]\nkind = \"sweep\"\npoints = [[0, 0, 0], [9, 0, 0], [0, 1, 0]]\nradius = "
            "5\n[tool]",
            ":4:|thicker"},
        Bad{"[tool]",
            "[[spline]]\nkind = \"sweep\"\npoints = [[90, 0, 0], [99, 0, 0]]\nradius = 2\n[tool]",
            ":4:|does not change"},
        Bad{"[tool]", "[no_go]\n[tool]", "[[no_go]]"},
        Bad{"[tool]", "[[no_go]]\n[tool]", ":4:|tool must be a table"},
        Bad{"[tool]", "[[no_go]]\ntool = { shape = \"ball\", radius = 3 }\n[tool]",
            "place|3 numbers"},
        Bad{"[tool]",
            "[[no_go]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [90, 0, 0]\n[tool]",
            ":4:|no material"},
        Bad{"[tool]",
            "[[no_go]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [9, 6, 2]\nat = 1\n[tool]",
            ":7:|'at'"},
        Bad{"[tool]",
            "[[no_go]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [9, 6, 2]\naxis = [0, 0, "
            "0]\n[tool]",
            ":7:|zero"},
        Bad{"label = \"B\"",
            "mode = \"smooth\"\n[[no_go]]\ntool = { shape = \"ball\", radius = 3 "
            "}\nplace = [9, 6, 2]",
            ":13:|smooth|protected"},
        Bad{"to = [25, 6, 6]", "to = [25, 6, 6]\nalong = [[1, 2, 3]]", ":15:|remove to"},
        Bad{"[tool]", "[layer]\n[tool]", ":4:|[[layer]]"},
        Bad{"[tool]", "[[layer]]\nplace = [1, 2, 3]\n[tool]", ":4:|tool must be a table"},
        Bad{"[tool]",
            "[[layer]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [9, 6, 2]\n[tool]",
            "material"},
        Bad{"[tool]",
            "[[layer]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [90, 6, 2]\nmaterial = "
            "\"oak\"\n[tool]",
            ":4:|contains no material"},
        Bad{"to = [25, 6, 6]", "along = []", ":14:|one point"},
        Bad{"to = [25, 6, 6]", "along = [[1, 2]]", ":14:|[x, y, z]"},
        Bad{"to = [25, 6, 6]", "along = [[9, 6, 8], [9, 6, 8]]", ":13:|along"},
        Bad{"to = [25, 6, 6]", "along = [[9, 6, 8]]\nstraight = 1", ":15:|true or false"},
        Bad{"to = [25, 6, 6]", "arc = 3", ":14:|table"},
        Bad{"to = [25, 6, 6]", "arc = { centre = [0, 6, 8], turn_deg = 0 }", ":14:|turn_deg"},
        Bad{"to = [25, 6, 6]", "arc = { centre = [-5, 6, 0], turn_deg = 90 }",
            ":13:|away from the centre"},
        Bad{"to = [25, 6, 6]", "arc = { center = [0, 6, 0], turn_deg = 90 }", ":14:|'centre'"},
        Bad{"speed = 40", "speed = 40\nlead = 3", ":16:|lead"},
        Bad{"speed = 40", "speed = 40\nlead = { entry = -1 }", ":16:|entry"},
        Bad{"speed = 40", "speed = 40\nlead = true\naxis = [0, 1, 1]", ":13:|constant axis"},
        Bad{"label = \"A\"", "label = \"A\"\nlead = true", ":10:|first move"},
        Bad{"shape = \"finger\"\nks = 0.4",
            "shape = \"gouge\"\nsweep = 7.5\nwidth = 8\nthickness = 1", "whole number|2 to 11"},
        Bad{"[force]", "[motion]\nrate_hz = 0\n[force]", "rate_hz"}));

TEST(Scene, UsesEnergyUnlessItGivesAForceForEachPoint) {
  const auto model_of = [](const std::string& force) {
    std::string text = kGood;
    text.replace(text.find("[force]\nkf = 0.001\n"), 19, force);
    const Result<Scene> scene = parse_scene(text, "a.toml", ".");
    EXPECT_TRUE(scene.ok()) << scene.error();
    return scene.value().force.law.model;
  };
  EXPECT_EQ(model_of(""), ForceModel::energy);
  EXPECT_EQ(model_of("[force]\nu = 3\n"), ForceModel::energy);
  EXPECT_EQ(model_of("[force]\nkf = 0.001\n"), ForceModel::paper);
  EXPECT_EQ(model_of("[[material]]\nname = \"soap\"\nkf = 0.001\n"), ForceModel::paper);
  EXPECT_EQ(model_of("[force]\nmodel = \"series\"\nkf = 0.001\n"), ForceModel::series);
}

// A preset is a tool that can be bought. Its numbers can be changed, its shape cannot.
TEST(Scene, PresetsAreTools) {
  const auto scene_with = [](const std::string& tool) {
    return parse_scene("[stock]\nblock = [10, 10, 10]\npitch = 1\n[tool]\n" + tool +
                           "\n[[move]]\nto = [0, 0, 12]\n",
                       "a.toml", ".");
  };
  for (const ToolPreset& preset : tool_presets()) {
    EXPECT_TRUE(check_tool(preset.tool).ok()) << preset.name;
    const auto scene = scene_with("preset = \"" + std::string(preset.name) + "\"");
    ASSERT_TRUE(scene.ok()) << scene.error();
    EXPECT_EQ(scene.value().tools.front(), preset.tool) << preset.name;
  }
  const auto changed = scene_with("preset = \"round bur 4\"\nradius = 0.8");
  ASSERT_TRUE(changed.ok()) << changed.error();
  EXPECT_EQ(std::get<BallTool>(changed.value().tools.front()).radius, 0.8);
  const auto unknown = scene_with("preset = \"round bur 44\"");
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().find("did you mean \"round bur 4\""), std::string::npos)
      << unknown.error();
  EXPECT_FALSE(scene_with("preset = \"round bur 4\"\nshape = \"flat\"").ok());
}

TEST(Scene, KeysAreInheritedAndTicksCounted) {
  const std::string text = kGood + R"([[move]]
to = [25, 6, 26]
[[move]]
axis = [1, 0, 0]
turn_deg_s = 90
wait_s = 0.25
mode = "touch"
[[move]]
to = [10, 6, 26]
tool = { ks = 2 }
)";
  const auto scene = parse_scene(text, "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  const Scene& s = scene.value();
  ASSERT_EQ(s.moves.size(), 5u);
  EXPECT_EQ(s.moves[2].speed_mm_s, 40);
  // The distance |(30, 0, -2)| mm at 40 mm/s, rounded up to ticks of 1 ms.
  EXPECT_EQ(plan_move(s, s.moves[0], s.moves[1]).value().ticks, 752);
  EXPECT_EQ(plan_move(s, s.moves[1], s.moves[2]).value().ticks, 500);
  EXPECT_EQ(plan_move(s, s.moves[2], s.moves[3]).value().ticks, 1000);
  EXPECT_EQ(plan_move(s, s.moves[2], s.moves[3]).value().dwell_ticks, 250);
  EXPECT_EQ(s.moves[4].mode, Mode::touch);
  EXPECT_EQ(std::get<Finger>(s.tools[s.moves[4].tool]).ks, 2);
  EXPECT_EQ(std::get<Finger>(s.tools[s.moves[4].tool]).length, 15)
      << "keys of the tool before are kept";
  const auto carving = carve(s, {});
  ASSERT_TRUE(carving) << carving.error();
  EXPECT_EQ(carving.value().summary.ticks, 752 + 500 + 1250 + 375);
  EXPECT_EQ(carving.value().trace.size(), 752u + 500 + 1250 + 375);
  EXPECT_DOUBLE_EQ(carving.value().trace.back().time_s, 2.877);
}

TEST(Scene, AnAxisMayHaveAnyLengthAndAPauseIsATick) {
  const auto scene = parse_scene(kGood + R"([[move]]
axis = [0, 0, 1e200]
wait_s = 0.01
[[move]]
axis = [0, 0, 1e-200]
)",
                                 "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  const Scene& s = scene.value();
  EXPECT_EQ(plan_move(s, s.moves[1], s.moves[2]).value().ticks, 0);
  EXPECT_EQ(plan_move(s, s.moves[1], s.moves[2]).value().dwell_ticks, 10);
  EXPECT_EQ(plan_move(s, s.moves[2], s.moves[3]).value().ticks, 1);
  EXPECT_EQ(s.moves[3].axis, Vec3(0, 0, 1));
}

// Curved paths: through their points, or around a centre. A tool with `lead` enters, follows the
// path, and leaves the wood. The next move begins at its last position.
TEST(Scene, MovesFollowCurvesAndArcs) {
  const std::string begin = R"([stock]
block = [60, 60, 10]
pitch = 0.5
[tool]
shape = "vee"
angle_deg = 60
width = 6
thickness = 1
length = 20
[[move]]
to = [10, 30, 12]
[[move]]
speed = 50
)";
  std::vector<Pose> poses;
  const auto carved = [&](const std::string& moves) {
    poses.clear();
    const auto scene = parse_scene(begin + moves, "scene.toml", ".");
    EXPECT_TRUE(scene.ok()) << scene.error();
    CarveOptions options;
    options.each = [&](const TriDexel&, const CarvedTick& tick, const CarvedTick*) {
      poses.push_back(tick.pose);
      return true;
    };
    const auto done = carve(scene.value(), options);
    EXPECT_TRUE(done.ok()) << done.error();
  };
  const auto nearest = [&](const Vec3& at) {
    double best = 1e9;
    for (const Pose& pose : poses) best = std::min(best, (pose.tip - at).norm());
    return best;
  };
  carved("along = [[20, 40, 12], [30, 30, 11], [45, 45, 9]]\n");
  for (const Vec3& at : {Vec3(20, 40, 12), Vec3(30, 30, 11), Vec3(45, 45, 9)})
    EXPECT_LT(nearest(at), 0.06);
  EXPECT_LT((poses.back().tip - Vec3(45, 45, 9)).norm(), 1e-9);
  for (size_t i = 1; i < poses.size(); i++) {  // ticks of equal length, and no turn
    EXPECT_NEAR((poses[i].tip - poses[i - 1].tip).norm(), 0.05, 0.001);
    EXPECT_LT((poses[i].frame - poses[0].frame).norm(), 1e-9);
  }
  carved("along = [[20, 40, 12], [30, 30, 11]]\nstraight = true\n");
  EXPECT_LT(nearest(Vec3(15, 35, 12)), 0.06);
  EXPECT_LT(nearest(Vec3(25, 35, 11.5)), 0.06);

  carved("arc = { centre = [30, 30, 0], turn_deg = 180 }\n");
  for (const Pose& pose : poses) {
    EXPECT_NEAR((pose.tip - Vec3(30, 30, 12)).norm(), 20, 0.01);
    EXPECT_LT(pose.tip.y(), 30.01);  // counterclockwise from the left passes below
  }
  EXPECT_LT((poses.back().tip - Vec3(50, 30, 12)).norm(), 1e-9);

  carved(
      "arc = { centre = [30, 30, 0], turn_deg = -360 }\nlead = { entry = 5, lift = 4 }\n[[move]]\n"
      "to = [14, 30, 8]\n");
  double deepest = 1e9;
  size_t led = 0;
  for (const Pose& pose : poses) {
    deepest = std::min(deepest, pose.tip.z());
    const Vec3 out = Vec3(pose.tip.x() - 30, pose.tip.y() - 30, 0).normalized();
    const Vec3 tangent(out.y(), -out.x(), 0);
    led += pose.frame.col(0).dot(tangent) > 0.995;
  }
  EXPECT_NEAR(deepest, 8, 1e-6);
  // The last move also uses `lead`.
  EXPECT_GT(led, poses.size() * 8 / 10);
  EXPECT_LT((poses.back().tip - Vec3(14, 30, 12)).norm(), 1e-9);
  carved("lead = { lift = 3 }\n");
  EXPECT_LT(nearest(Vec3(10, 30, 9)), 1e-9);
  EXPECT_LT((poses.back().tip - Vec3(10, 30, 12)).norm(), 1e-9);
}

// Layers of enamel, dentine and pulp. Each has the right volume and its own force. A replayed
// document gives the same forces.
TEST(Scene, LayersAreOfTheirMaterial) {
  const std::string text = R"([stock]
block = [24, 16, 14]
pitch = 0.25
material = "enamel"
[[material]]
name = "enamel"
u = 60
[[material]]
name = "dentine"
u = 20
[[material]]
name = "pulp"
u = 1
[[layer]]
tool = { shape = "ball", radius = 6 }
place = [12, 8, 1]
material = "dentine"
[[layer]]
tool = { shape = "flat", radius = 2, length = 40 }
place = [12, 8, 4]
material = "pulp"
[force]
model = "energy"
[tool]
shape = "box"
size = [1, 2, 20]
[[move]]
to = [-3, 8, 6]
[[move]]
to = [27, 8, 6]
speed = 100
)";
  const auto scene = parse_scene(text, "scene.toml", ".");
  ASSERT_TRUE(scene.ok()) << scene.error();
  const auto stock = make_stock(scene.value().stock, "scene.toml", {});
  ASSERT_TRUE(stock.ok()) << stock.error();
  const double pi = std::acos(-1.0), ball = 4.0 / 3 * pi * 216;
  // The rod is from 4 to 14 high. Its part in the ball is 9 long at its middle and shorter at its
  // rim.
  const double rod = pi * 4 * 10;
  double both = 0;
  for (double r = 0.005; r < 2; r += 0.01)
    both += 2 * pi * r * 0.01 * (7 + std::sqrt(36 - r * r) - 4);
  const std::vector<double> volume = mass_of(stock.value()->snapshot(), {0, 0, 0}).volume_mm3;
  EXPECT_NEAR(volume[0], 24 * 16 * 14 - ball - (rod - both), 1e-3 * 24 * 16 * 14);
  EXPECT_NEAR(volume[1], ball - both, 2e-3 * ball);
  EXPECT_NEAR(volume[2], rod, 2e-2 * rod);  // eight cells in radius
  EXPECT_NEAR(volume[0] + volume[1] + volume[2], 24 * 16 * 14, 1e-6);

  const auto folder = TemporaryFolder::make();
  ASSERT_TRUE(folder);
  CarveOptions options;
  options.document = folder.value()->path() / "tooth.kibori";
  const auto carving = carve(scene.value(), options);
  ASSERT_TRUE(carving.ok()) << carving.error();
  // The cut is 2 mm wide and 8 mm high. At first it is all in enamel. In the middle it passes
  // through enamel, dentine and pulp.
  double outside = 0, inside = 1e9;
  for (const TraceRow& row : carving.value().trace) {
    const double x = row.result.pose.tip.x(), force = row.result.wrench.force.norm();
    if (x > 1 && x < 4) outside = std::max(outside, force);
    if (x > 11.5 && x < 12.5) inside = std::min(inside, force);
  }
  EXPECT_NEAR(outside, 60 * 2 * 8, 0.02 * 60 * 16);
  EXPECT_LT(inside, 0.2 * outside);
  ReplayOptions again;
  again.pitch_mm = 0.5;
  const auto document = Document::open(options.document, Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  const auto replayed = replay_document(*document.value(), again);
  ASSERT_TRUE(replayed.ok()) << replayed.error();
  double now = 1e9;
  for (const TraceRow& row : replayed.value().carving.trace)
    if (row.result.pose.tip.x() > 11.5 && row.result.pose.tip.x() < 12.5)
      now = std::min(now, row.result.wrench.force.norm());
  EXPECT_NEAR(now, inside, 0.2 * outside);
}

// A move without a path is one dab, at the tool. A path has one where it begins, and then one at
// every quarter of the brush's radius. A missing key keeps the value of the previous move.
TEST(Scene, BrushesMakeDabs) {
  const std::string begin = R"([stock]
block = [20, 12, 10]
pitch = 0.5
[tool]
shape = "ball"
radius = 1
[force]
model = "energy"
[[move]]
to = [10, 0, 10]
mode = "off"
[[move]]
mode = "smooth"
brush = { radius = 4, strength = 0.8, falloff = "linear", sigma = 0.9 }
)";
  const std::string moves = R"([[move]]
to = [10, 2.6, 10]
speed = 100
brush = { falloff = "constant", keep_volume = true, spacing = 0.5 }
[[move]]
mode = "inflate"
brush = { strength = -0.5 }
)";
  Reshaper reshaper;
  Brush brush{4, 0.8, Falloff::linear, 0.9};
  auto scene = parse_scene(begin, "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  auto model = make_stock(scene.value().stock, "", {}).value();
  ASSERT_TRUE(reshaper.dab(*model, FieldVerb::smooth, brush, Vec3(10, 0, 10)).ok());
  auto carving = carve(scene.value(), {});
  ASSERT_TRUE(carving) << carving.error();
  EXPECT_EQ(carving.value().summary.state_hash, model->content_hash());
  EXPECT_GT(carving.value().summary.removed_mm3, 1);
  EXPECT_NEAR(carving.value().summary.removed_mm3 - carving.value().summary.deposited_mm3,
              2400 - model->volume_mm3(), 0.01);

  scene = parse_scene(begin + moves, "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  brush.falloff = Falloff::constant;
  brush.keep_volume = true;
  brush.spacing = 0.5;
  for (const double y : {0.0, 2.0})
    ASSERT_TRUE(reshaper.dab(*model, FieldVerb::smooth, brush, Vec3(10, y, 10)).ok());
  brush.strength = -0.5;
  ASSERT_TRUE(reshaper.dab(*model, FieldVerb::inflate, brush, Vec3(10, 2.6, 10)).ok());
  carving = carve(scene.value(), {});
  ASSERT_TRUE(carving) << carving.error();
  // The scene rounds the places of the dabs differently from the calls above.
  EXPECT_NEAR(carving.value().summary.volume_mm3, model->volume_mm3(), 1e-3);
}

// A brush presses a user's own picture in. A move without a brush keeps it.
TEST(Scene, ATextureIsAFile) {
  const test::Folder folder;
  std::vector<uint8_t> pixels(64, 0);
  for (size_t i = 0; i < 64; i += 2) pixels[i] = 255;
  ASSERT_TRUE(write_png_grey8(folder / "stripes.png", 8, 8, pixels).ok());
  const auto read = [&](const std::string& brush, const std::optional<std::filesystem::path>& in) {
    return parse_scene(
        "[stock]\nblock = [20, 12, 10]\npitch = 0.5\n[tool]\nshape = \"ball\"\n"
        "radius = 1\n[[move]]\nto = [4, 6, 10]\nmode = \"off\"\n[[move]]\n"
        "to = [16, 6, 10]\nspeed = 100\nmode = \"inflate\"\nbrush = { radius = 4, " +
            brush + " }\n[[move]]\nto = [16, 8, 10]\n",
        "scene.toml", in);
  };
  const auto scene = read("texture = \"stripes.png\"", folder.path);
  ASSERT_TRUE(scene) << scene.error();
  EXPECT_EQ(scene.value().moves.back().brush.alpha, Alpha::picture);
  ASSERT_TRUE(scene.value().moves.back().brush.picture);
  const auto striped = carve(scene.value(), {}),
             plain = carve(read("strength = 1", folder.path).value(), {});
  ASSERT_TRUE(striped) << striped.error();
  EXPECT_NE(striped.value().summary.state_hash, plain.value().summary.state_hash);
  const std::pair<const char*, const char*> bad[] = {
      {"texture = \"none.png\"", "none.png"},
      {"texture = 3", "texture"},
      {"texture = \"stripes.png\", alpha = \"fur\"", "both texture"},
      {"alpha = \"picture\"", "needs a picture"}};
  for (const auto& [brush, expected] : bad) {
    const auto failed = read(brush, folder.path);
    ASSERT_FALSE(failed) << brush;
    EXPECT_NE(failed.error().find(expected), std::string::npos) << failed.error();
  }
  const auto page = read("texture = \"stripes.png\"", std::nullopt);
  ASSERT_FALSE(page);
  EXPECT_NE(page.error().find("must not use files"), std::string::npos) << page.error();
}

// Consecutive moves with the same warp are one stroke, which begins where the mode begins. The
// default strength is 1, and a replayed document has the same bytes. Clay is pressed by default.
TEST(Scene, WarpsClayAndSymmetry) {
  const std::string stock = R"([stock]
block = [20, 12, 10]
pitch = 0.5
room_mm = 8
material = "MATERIAL"
[tool]
shape = "ball"
radius = 2
[force]
model = "energy"
[symmetry]
planes = "x"
[[move]]
to = [5, 6, 10]
mode = "off"
speed = 100
)";
  const auto of = [&](const std::string& material, const std::string& moves) {
    std::string text = stock + moves;
    text.replace(text.find("MATERIAL"), 8, material);
    return parse_scene(text, "scene.toml", ".");
  };
  const auto hash = [&](const std::string& moves) {
    const auto scene = of("oak", moves);
    EXPECT_TRUE(scene) << scene.error();
    const auto carving = carve(scene.value(), {});
    EXPECT_TRUE(carving) << carving.error();
    return carving.value().summary.state_hash;
  };
  const std::string grab = R"([[move]]
to = [5, 6, 13]
mode = "grab"
brush = { radius = 3 }
)";
  const uint64_t none = hash("");
  EXPECT_NE(hash(grab), none);
  EXPECT_EQ(hash(grab + "[[move]]\nto = [6, 6, 12]\n[[move]]\nto = [5, 6, 10]\n"), none);
  EXPECT_EQ(hash(grab + "[[move]]\nto = [9, 2, 12]\n[[move]]\nto = [5, 6, 13]\n"), hash(grab));
  // Another brush begins another stroke.
  EXPECT_NE(hash(grab + "[[move]]\nto = [5, 6, 10]\nbrush = { strength = 0.5 }\n"), none);

  const auto both = of("oak", grab);
  ASSERT_TRUE(both);
  EXPECT_EQ(both.value().moves[1].brush.strength, 1);
  const auto carving = carve(both.value(), {});
  ASSERT_TRUE(carving) << carving.error();
  double left = 0, right = 0;
  carving.value().model->field(Axis::z).view().for_spans(26, 28,
                                                         [&](const Span& s) { left = s.out; });
  carving.value().model->field(Axis::z).view().for_spans(45, 28,
                                                         [&](const Span& s) { right = s.out; });
  EXPECT_GT(left, 36 + 4);
  // The surface's triangles are not images of each other.
  EXPECT_NEAR(left, right, 0.3);

  const auto clay = of("clay", "[[move]]\nto = [5, 6, 8.5]\nmode = \"cut\"\n");
  ASSERT_TRUE(clay) << clay.error();
  EXPECT_EQ(clay.value().moves[1].mode, Mode::press);
  EXPECT_NEAR(carve(clay.value(), {}).value().summary.volume_mm3, 2400, 0.02);
  const auto wheel = of("clay", "[[move]]\nto = [5, 6, 8.5]\nmode = \"turn\"\n");
  ASSERT_TRUE(wheel) << wheel.error();
  EXPECT_EQ(wheel.value().moves[1].mode, Mode::throw_clay);

  for (const char* bad :
       {"[symmetry]\nplanes = \"w\"\n", "[symmetry]\nfold = 17\n", "[symmetry]\nfold = 2.5\n",
        "[symmetry]\naxis = \"q\"\n", "[symmetry]\nplane = \"x\"\n"}) {
    std::string text = stock;
    text.replace(text.find("[symmetry]"), 22, bad);
    text.replace(text.find("MATERIAL"), 8, "oak");
    EXPECT_FALSE(parse_scene(text, "scene.toml", ".")) << bad;
  }
  EXPECT_FALSE(of("oak", "[[move]]\nmode = \"paint\"\nbrush = { color = \"red\" }\n"));
  EXPECT_FALSE(of("oak", "[[move]]\nmode = \"grab\"\nbrush = { strength = -0.5 }\n"));
}

TEST(Scene, SummaryAddsUp) {
  const auto scene = parse_scene(kGood, "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  const auto carving = carve(scene.value(), {});
  ASSERT_TRUE(carving) << carving.error();
  const CarveSummary& s = carving.value().summary;
  EXPECT_NEAR(s.removed_mm3 + s.volume_mm3, 2400, 1e-3);
  EXPECT_NEAR(static_cast<double>(s.points_removed) * 0.125, s.removed_mm3, 0.02 * s.removed_mm3);
  const auto marks = contact_marks(carving.value());
  ASSERT_EQ(marks.size(), 4u);
  EXPECT_EQ(marks[1].label, "A′");
  EXPECT_EQ(marks[2].label, "B′");
  for (const int threads : {2, 8}) {
    CarveOptions options;
    options.threads = threads;
    EXPECT_EQ(carve(scene.value(), options).value().summary.state_hash, s.state_hash);
  }
}

// Model `energy`: the work of the tools is u times the volume that they removed, less the volume
// without a force. A stroke that ends in air has none.
TEST(Scene, ReportsTheVolumeThatCausesNoForce) {
  const std::string begin = R"([stock]
block = [20, 12, 10]
pitch = 0.5
[tool]
shape = "ball"
radius = 2
[force]
model = "energy"
u = 3
[[move]]
to = [-5, 6, 8]
[[move]]
speed = 20
)";
  const std::string inside = "to = [12, 6, 7]\n", leaving = "to = [26, 6, 7]\n";
  for (const std::string& more : {inside, inside + "[[move]]\nto = [4, 5, 6]\n", leaving}) {
    const auto scene = parse_scene(begin + more, "scene.toml", ".");
    ASSERT_TRUE(scene) << scene.error();
    const auto carving = carve(scene.value(), {});
    ASSERT_TRUE(carving) << carving.error();
    const CarveSummary& s = carving.value().summary;
    double work = 0;
    for (const TraceRow& row : carving.value().trace)
      work -= row.result.wrench.force.dot(row.result.motion.travel);
    EXPECT_NEAR(work, 3 * (s.removed_mm3 - s.without_force_mm3), 1e-6 * work) << more;
    const bool leaves = more == leaving;
    EXPECT_EQ(s.without_force_mm3 > 1e-6, !leaves) << s.without_force_mm3 << " " << more;
    EXPECT_EQ(summary_text(s).find("no force") != std::string::npos, !leaves);
    EXPECT_EQ(summary_json(s).find("without_force_mm3") != std::string::npos, !leaves);
  }
}

// A plane moves through a block. Its force times its path is the work for the exposed face.
TEST(Scene, ACuttersForceFollowsTheExposedFace) {
  for (const double kerf : {0.0, 1.0}) {
    std::string text =
        kGood +
        "[[material]]\nname = \"lime\"\ngc = 0.4\nu = 3\n[[cutter]]\npoint = [9.1, 0, 0]\n"
        "normal = [1, 0, 0]\nfeed = [0, 0, -2]\nspeed = 50\n";
    if (kerf > 0) text += "kerf = 1\n";
    text.replace(text.find("pitch = 0.5"), 11, "pitch = 0.5\nmaterial = \"lime\"");
    text.replace(text.find("kf = 0.001"), 10, "model = \"energy\"");
    const auto scene = parse_scene(text, "scene.toml", ".");
    ASSERT_TRUE(scene.ok()) << scene.error();
    Scene still = scene.value();
    still.moves.resize(1);
    const auto made = carve(still, {});
    ASSERT_TRUE(made.ok()) << made.error();
    const double per_mm = 12 * (kerf > 0 ? 3 * kerf : 0.4);  // N over a height of 10
    double work = 0, largest = 0;
    for (const TraceRow& row : made.value().trace) {
      EXPECT_LE(row.result.wrench.force.head<2>().norm(), 1e-12);
      EXPECT_GE(row.result.wrench.force.z(), 0);
      largest = std::max(largest, row.result.wrench.force.z());
      work += row.result.wrench.force.z() * 0.05;
    }
    EXPECT_NEAR(work, 10 * per_mm, 0.05 * 10 * per_mm) << kerf;
    EXPECT_NEAR(largest, per_mm, 0.15 * per_mm) << kerf;
    EXPECT_NEAR(static_cast<double>(made.value().trace.size()), 10 / 0.05, 12);
  }
}

TEST(Scene, SplinesShapeTheStock) {
  const auto scene = parse_scene(
      kGood +
          "[[spline]]\nkind = \"sweep\"\npoints = [[4, 6, 10], [16, 6, 10]]\nradius = 2\n"
          "[[spline]]\nkind = \"revolve\"\nmode = \"cut\"\naxis_point = [10, 6, 0]\n"
          "points = [[12, 6, -1], [12, 6, 3]]\nthrough = false\n",
      "scene.toml", ".");
  ASSERT_TRUE(scene.ok()) << scene.error();
  Scene still = scene.value();
  still.moves.resize(1);
  const auto made = carve(still, {});
  ASSERT_TRUE(made.ok()) << made.error();
  // Half of a rod with half balls at its ends, and a hole 3 deep.
  const double rod = 0.5 * 3.14159265 * (4 * 12 + 4.0 / 3 * 8), hole = 3.14159265 * 4 * 3;
  EXPECT_NEAR(made.value().summary.deposited_mm3, rod, 0.02 * rod);
  EXPECT_NEAR(made.value().summary.removed_mm3, hole, 0.02 * hole);
  EXPECT_NEAR(made.value().summary.volume_mm3, 20 * 12 * 10 + rod - hole, 0.02 * rod);
}

TEST(Scene, NothingCutsTheProtectedRegion) {
  for (const std::string model : {"energy", "series"}) {
    const auto scene = parse_scene(kGood +
                                       "[[no_go]]\nname = \"ball\"\ntool = { shape = \"ball\", "
                                       "radius = 3 }\nplace = [10, 6, 4]\n",
                                   "scene.toml", ".");
    ASSERT_TRUE(scene.ok()) << scene.error();
    Scene with = scene.value();
    with.force.law.model = *value_of<ForceModel>(model);
    Scene without = with;
    without.no_go.clear();
    const auto a = carve(with, {}), b = carve(without, {});
    ASSERT_TRUE(a.ok() && b.ok());
    const CarveSummary &guarded = a.value().summary, &free = b.value().summary;
    EXPECT_LT(guarded.removed_mm3, free.removed_mm3);
    EXPECT_NEAR(guarded.volume_mm3 + guarded.removed_mm3, 20 * 12 * 10, 1e-6 * 2400);
    EXPECT_EQ(guarded.bodies, 1u);
    const BodyList& bodies = a.value().bodies;
    ASSERT_EQ(bodies.all.size(), 2u);
    EXPECT_EQ(bodies.all[1].name, "ball");
    EXPECT_TRUE(bodies.all[1].no_go && !bodies.all[1].visible);
    // The protected part of the stock is still there.
    Removed within;
    contact(*a.value().model, no_go_of(bodies, 1).value()->solid(), {}, within);
    const double below = 4.0 / 3 * 3.14159265 * 27;  // all of the ball is in the stock
    EXPECT_NEAR(within.volume() / 8, below, 0.03 * below);
  }
}

// One tick of 1000 N among others of 10 N: it is marked, and the scale of the others is the same as
// without it.
TEST(Scene, ASpikeDoesNotFlattenThePlot) {
  const auto plot = [](double spike_n) {
    Carving carving;
    for (int i = 0; i < 2000; i++) {
      TraceRow row;
      row.time_s = (i + 1) / 1000.0;
      row.result.wrench.force = Vec3(0, 0, i == 700 ? spike_n : i < 500 ? 0 : 10);
      carving.trace.push_back(row);
    }
    return forces_svg(carving, "a < b & c", model_note(ForceModel::energy));
  };
  const auto count = [](const std::string& text, const std::string& what) {
    size_t n = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) n++;
    return n;
  };
  const std::string even = plot(10), spiky = plot(1000);
  EXPECT_EQ(count(even, "class=\"spike\""), 0u);
  EXPECT_EQ(count(spiky, "class=\"spike\""), 2u);  // of the magnitude, and of its part along z
  EXPECT_EQ(count(spiky, "<title>1000 N</title>"), 2u);
  // The scale of |F| and of its parts goes to 10 or 15, not to 1000.
  for (const std::string& text : {even, spiky}) {
    EXPECT_EQ(count(text, ">10</text>"), 2u);
    for (const char* beyond : {">20</text>", ">100</text>", ">1000</text>"})
      EXPECT_EQ(count(text, beyond), 0u);
    EXPECT_EQ(count(text, ">Force [N]<"), 2u);
    EXPECT_EQ(count(text, ">Moment [N mm]<"), 2u);
    EXPECT_EQ(count(text, ">Time [s]<"), 1u);
    EXPECT_NE(text.find("Energy: the force of the cut"), std::string::npos);
    EXPECT_NE(text.find("a &lt; b &amp; c"), std::string::npos);
  }
}

TEST(Scene, StocksHaveTheirVolume) {
  for (const auto& [stock, volume] : {std::pair{"sphere = 8", 4.0 / 3 * 3.14159265 * 512},
                                      std::pair{"cylinder = [6, 10]", 3.14159265 * 360}}) {
    const auto scene = parse_scene(replaced("block = [20, 12, 10]", stock), "scene.toml", ".");
    ASSERT_TRUE(scene) << scene.error();
    const auto model = make_stock(scene.value().stock, "scene.toml", {});
    ASSERT_TRUE(model) << model.error();
    EXPECT_NEAR(model.value()->volume_mm3(), volume, 0.005 * volume);
  }
}

// A deposit beyond the room of the stock is complete, because the lattice grows.
TEST(Scene, ADepositFindsRoom) {
  const auto scene =
      parse_scene(replaced("speed = 40", "speed = 40\nmode = \"deposit\""), "scene.toml", ".");
  ASSERT_TRUE(scene) << scene.error();
  std::vector<std::string> warnings;
  CarveOptions options;
  options.warning = [&](const std::string& text) { warnings.push_back(text); };
  const auto carving = carve(scene.value(), options);
  ASSERT_TRUE(carving) << carving.error();
  EXPECT_EQ(warnings.size(), 0u);
  EXPECT_TRUE(carving.value().model->lattice().grown());
  EXPECT_GT(carving.value().summary.deposited_mm3, 0);
  EXPECT_NEAR(carving.value().summary.volume_mm3, 2400 + carving.value().summary.deposited_mm3,
              1e-2);
}

// ---- STL ----

std::string binary_stl(uint32_t promised, int there) {
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&promised), 4);
  for (int i = 0; i < there; i++) {
    const float t[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(i)};
    bytes.append(reinterpret_cast<const char*>(t), 48);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Stl, ReadsBothKinds) {
  const std::string binary = binary_stl(5, 5);
  const auto a = parse_stl(binary, "a.stl");
  ASSERT_TRUE(a) << a.error();
  EXPECT_EQ(a.value().triangles.size(), 5u);
  std::string solid = binary;
  std::memcpy(solid.data(), "solid facet", 11);  // binary that looks like text at first
  EXPECT_TRUE(parse_stl(solid, "a.stl"));
  const std::string text =
      "solid x\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex +1.5e0 0 0\n vertex 0 1 "
      "0\n "
      "endloop\n endfacet\nendsolid x\n";
  const auto b = parse_stl(text, "b.stl");
  ASSERT_TRUE(b) << b.error();
  ASSERT_EQ(b.value().triangles.size(), 1u);
  EXPECT_EQ(b.value().vertices[1].x(), 1.5);
}

TEST(Stl, RefusesWrongCounts) {
  const auto message = [](const std::string& bytes) {
    const auto mesh = parse_stl(bytes, "x.stl");
    return mesh ? std::string("accepted") : mesh.error();
  };
  EXPECT_NE(message(binary_stl(6, 5)).find("promises 6 triangles, but the file holds 5"),
            std::string::npos);
  EXPECT_NE(message(binary_stl(0xffffffffu, 5)).find("promises"), std::string::npos);
  EXPECT_NE(message("short").find("at least 84 bytes"), std::string::npos);
  EXPECT_NE(message("").find("84"), std::string::npos);
  std::string nan = binary_stl(2, 2);
  const uint32_t bits = 0x7fc00000;
  std::memcpy(nan.data() + 84 + 12, &bits, 4);
  EXPECT_NE(message(nan).find("byte 96"), std::string::npos);
  const std::string head = "solid x\nfacet normal 0 0 1\nouter loop\n";
  EXPECT_NE(message(head + "vertex 0 0 zero\n").find("x.stl:4:"), std::string::npos);
  EXPECT_NE(message(head + "vertex 0 0 0\nendfacet\n").find("vertices instead of three"),
            std::string::npos);
  EXPECT_NE(message(head + "vertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\n")
                .find("endsolid"),
            std::string::npos);
  test::Random random;  // any truncation of a good file is refused, none crashes
  const std::string good = binary_stl(9, 9);
  for (size_t length = 0; length < good.size(); length += 7)
    EXPECT_NE(message(good.substr(0, length)), "accepted");
  for (int i = 0; i < 2000; i++) {
    std::string noise = good;
    for (int k = 0; k < 8; k++)
      noise[static_cast<size_t>(random.integer(0, static_cast<int>(noise.size()) - 1))] =
          static_cast<char>(random.integer(0, 255));
    static_cast<void>(message(noise));
  }
}

TEST(MeshFile, NamesWhatItCannotRead) {
  EXPECT_NE(read_mesh("nowhere.stl").error().find("no such file"), std::string::npos);
  const auto folder = std::filesystem::path(testing::TempDir());
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  };
  EXPECT_NE(read_mesh(write("kibori_test.txt", "x")).error().find(".stl, .ply, .obj"),
            std::string::npos);
  EXPECT_FALSE(read_mesh(write("kibori_test.obj", "nonsense")));
  EXPECT_FALSE(
      read_mesh(write("kibori_test.ply", "ply\nformat ascii 1.0\nelement vertex 99999999\n")));
  EXPECT_FALSE(read_mesh(write("kibori_empty.stl", "")));
  const auto box =
      read_mesh(write("kibori_good.obj",
                      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"));
  ASSERT_TRUE(box) << box.error();
  EXPECT_EQ(box.value().triangles.size(), 4u);
}

}  // namespace
}  // namespace kibori::scene_tests
