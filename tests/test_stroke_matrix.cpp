// SPDX-License-Identifier: MIT
// Runs every mode, force model and variant of a stroke by three routes: a scene, a workpiece as in
// Python, and a servo with a device. The resulting document must verify and replay to the same
// state.
//
// A short run covers every pair of mode, model, variant and route. KIBORI_MATRIX=1 runs them all.
#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/body/workbench.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/live/live_carving.h>
#include <kibori/motion/mode.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/run/workpiece.h>
#include <kibori/scene/scene.h>

#include "tests/document_support.h"
#include "tests/live_rig.h"
#include "tests/support.h"

namespace kibori::stroke_matrix_tests {
namespace {

using namespace test;

enum class Variant { plain, symmetry, radial, two_hands, protects, stamp, layers, grain };
constexpr Names<8> names_of(Variant) {
  return {"plain", "symmetry", "radial", "two_hands", "protects", "stamp", "layers", "grain"};
}
enum class Route { scene, workpiece, servo };
constexpr Names<3> names_of(Route) { return {"scene", "workpiece", "servo"}; }
constexpr ForceModel kModels[] = {ForceModel::paper, ForceModel::energy, ForceModel::series};

struct Case {
  Mode mode;
  ForceModel model;
  Variant variant;
  Route route;

  std::string name() const {
    std::string text;
    for (const std::string_view part :
         {name_of(mode), name_of(model), name_of(variant), name_of(route)})
      text.append(text.empty() ? "" : " ").append(part);
    return text;
  }
  // A reshaping mode cannot be combined with two hands or with a protected body.
  bool refused() const {
    return reshapes(mode) && (variant == Variant::two_hands || variant == Variant::protects);
  }
};

// The scene of a case. Its stock is a block of about 20 x 16 x 10 mm, whose sides are no multiples
// of the pitch. The path leads into the block and along it, and then the tool turns. On a wheel the
// tool approaches from the side.
std::string scene_text(const Case& c) {
  std::string text = "schema = 1\n";
  if (c.variant == Variant::symmetry) text += "[symmetry]\nplanes = \"x\"\n";
  if (c.variant == Variant::radial) text += "[symmetry]\nfold = 3\naxis = \"z\"\n";
  text += "[stock]\nblock = [20.3, 16.1, 10.2]\npitch = 0.9\nroom_mm = 5\nmaterial = \"";
  text += c.variant == Variant::grain ? "oak" : "wax";
  text += "\"\n[tool]\nshape = \"ball\"\nradius = 2.6\n[force]\nmodel = \"";
  text += name_of(c.model);
  text += "\"\n";
  if (c.model == ForceModel::series) text += "strength = 60\n";
  text += "[motion]\nrate_hz = 500\n";
  if (c.variant == Variant::layers)
    text +=
        "[[layer]]\ntool = { shape = \"ball\", radius = 4 }\nplace = [10, 8, 3]\nmaterial = "
        "\"oak\"\n";
  if (c.variant == Variant::protects)
    text += "[[no_go]]\ntool = { shape = \"ball\", radius = 3 }\nplace = [11, 8, 4]\n";
  const bool wheel = on_wheel(c.mode);
  std::string mode(name_of(c.mode)), second_start, second_on;
  if (c.variant == Variant::two_hands) {
    second_start =
        "second = { to = [2, 4, 14], tool = { shape = \"ball\", radius = 2 }, mode = \"off\" }\n";
    second_on = "second = { to = [15, 4, 9.5], mode = \"deposit\" }\n";
  }
  std::string brush = reshapes(c.mode) ? "brush = { radius = 5 }\n" : "";
  // Model `energy` tests brushes with a texture.
  if (dabs(c.mode) && c.model == ForceModel::energy)
    brush = "brush = { radius = 5, alpha = \"leather\" }\n";
  text += "[[move]]\nto = " + std::string(wheel ? "[26, 8, 6]" : "[6, 7, 14]") +
          "\nspeed = 60\nmode = \"off\"\n" + second_start;
  text += "[[move]]\nto = " + std::string(wheel ? "[22, 8, 6]" : "[7, 8, 10.4]") + "\nmode = \"" +
          mode + "\"\n" + brush + second_on;
  if (c.variant == Variant::stamp) text += "stamp = { every = 3, lift = 2 }\n";
  text +=
      "[[move]]\nto = " + std::string(wheel ? "[16, 8, 5]" : "[12, 9, 8.7]") + "\nwait_s = 0.01\n";
  text +=
      "[[move]]\nto = " + std::string(wheel ? "[15, 8, 4]" : "[13, 10, 9.5]") + "\nroll_deg = 25\n";
  if (c.variant != Variant::stamp) text += "[[move]]\nto = [14, 10, 9]\naxis = [0.1, 0.2, 1]\n";
  return text;
}

// Checks that a document verifies and replays to its last state.
void expect_true(const std::filesystem::path& file, uint64_t state_hash) {
  auto document = Document::open(file, Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  EXPECT_EQ(wrongs(*document.value()), std::vector<std::string>());
  const auto replay = replay_document(*document.value(), {});
  ASSERT_TRUE(replay.ok()) << replay.error();
  EXPECT_EQ(replay.value().differs, 0);
  EXPECT_EQ(replay.value().carving.summary.state_hash, state_hash);
}

void expect_refused(const std::string& error) {
  EXPECT_TRUE(error.find("can't work together with a second hand") != std::string::npos ||
              error.find("can't work next to a protected body") != std::string::npos)
      << error;
}

// True if the mode changes a flat face. Fill, flatten and trim leave it unchanged.
bool changes(Mode mode) {
  return kind_of(mode) != ModeKind::none && mode != Mode::fill && mode != Mode::flatten &&
         mode != Mode::trim;
}

BodyAction protection(const SceneNoGo& no_go) {
  BodyProperties shown;
  shown.no_go = true;
  return {{}, BodyAdd{no_go.tool, no_go.pose, 0, shown}};
}

void run_scene(const Case& c, const std::filesystem::path& file) {
  const Result<Scene> scene = parse_scene(scene_text(c), "matrix", std::nullopt);
  if (!scene && c.refused()) return expect_refused(scene.error());
  ASSERT_TRUE(scene.ok()) << scene.error();
  CarveOptions options;
  options.document = file;
  options.keep_forces = true;
  const Result<Carving> carved = carve(scene.value(), options);
  if (c.refused()) {
    ASSERT_FALSE(carved.ok());
    return expect_refused(carved.error());
  }
  ASSERT_TRUE(carved.ok()) << carved.error();
  EXPECT_EQ(carved.value().unsaved, "");
  const CarveSummary& summary = carved.value().summary;
  if (changes(c.mode) && c.mode != Mode::paint && c.mode != Mode::mask) {
    EXPECT_GT(summary.removed_mm3 + summary.deposited_mm3, 0);
  }
  expect_true(file, summary.state_hash);
}

void run_workpiece(const Case& c, const std::filesystem::path& file) {
  if (c.variant == Variant::two_hands) return;  // a workpiece has one hand
  Case on_stock = c;
  if (c.refused()) on_stock.variant = Variant::plain;
  const Result<Scene> scene = parse_scene(scene_text(on_stock), "matrix", std::nullopt);
  ASSERT_TRUE(scene.ok()) << scene.error();
  const Scene& s = scene.value();
  auto made = Workpiece::make(s.stock, s.materials, 1);
  ASSERT_TRUE(made.ok()) << made.error();
  Workpiece& piece = *made.value();
  if (c.variant == Variant::protects) {
    const Result<Scene> with =
        parse_scene(scene_text({Mode::cut, c.model, c.variant, c.route}), "matrix", std::nullopt);
    ASSERT_TRUE(with.ok()) << with.error();
    const SceneNoGo& no_go = with.value().no_go.front();
    const auto added = piece.act(protection(no_go));
    ASSERT_TRUE(added.ok()) << added.error();
  }
  Pose at{s.moves.front().to_mm, frame_from_axis(s.moves.front().axis, 0)};
  for (size_t i = 1; i < s.moves.size(); i++) {
    const Move& to = s.moves[i];
    StrokeSettings settings = stroke_settings(s, to);
    settings.symmetry = s.symmetry;
    settings.symmetry.centre_mm = centre_of(piece.model().lattice());
    const Status begun = piece.begin(settings, at, "a stroke");
    if (c.refused()) {
      ASSERT_FALSE(begun.ok());
      return expect_refused(begun.error());
    }
    ASSERT_TRUE(begun.ok()) << begun.error();
    const ToolMotion motion{at, to.to_mm - at.tip,
                            rotation_between(at.frame, frame_from_axis(to.axis, to.roll_rad))};
    for (int k = 1; k <= 20; k++) {
      const auto done = piece.advance(motion.at(k / 20.0));
      ASSERT_TRUE(done.ok()) << done.error();
    }
    const auto ended = piece.end();
    ASSERT_TRUE(ended.ok()) << ended.error();
    at = motion.at(1);
  }
  const Status saved = piece.save(file, false);
  ASSERT_TRUE(saved.ok()) << saved.error();
  expect_true(file, piece.bodies().content_hash());
}

// A hand that follows the scene's moves.
VirtualDevice::Script along(const Scene& scene, const Vec3& centre, bool second) {
  std::vector<Pose> poses;
  for (const Move& move : scene.moves)
    poses.push_back(second ? Pose{move.second->to_mm, Mat3::Identity()}
                           : Pose{move.to_mm, frame_from_axis(move.axis, move.roll_rad)});
  return [poses, centre](double time_s) {
    const double at = std::min(time_s / 0.1, static_cast<double>(poses.size() - 1));
    const auto i = std::min(static_cast<size_t>(at), poses.size() - 2);
    const Pose &from = poses[i], &to = poses[i + 1];
    const Pose pose =
        ToolMotion{from, to.tip - from.tip, rotation_between(from.frame, to.frame)}.at(
            at - static_cast<double>(i));
    return VirtualDevice::Target{pose.tip - centre, pose.frame, 0};
  };
}

void run_servo(const Case& c, const std::filesystem::path& file) {
  const bool both = c.variant == Variant::two_hands;
  // A scene refuses some cases in which a servo only waits. They use the path of a cut.
  const Case path{c.refused() ? Mode::cut : c.mode, c.model, c.variant, c.route};
  const Result<Scene> scene = parse_scene(scene_text(path), "matrix", std::nullopt);
  ASSERT_TRUE(scene.ok()) << scene.error();
  const Scene& s = scene.value();
  auto stock = make_stock(s.stock, s.file, {});
  ASSERT_TRUE(stock.ok()) << stock.error();
  auto created = new_document(file, s, *stock.value());
  ASSERT_TRUE(created.ok()) << created.error();
  LiveSettings settings;
  settings.rate_hz = s.rate_hz;
  settings.tool = s.tools.front();
  settings.mode = c.mode;
  settings.brush.radius_mm = 5;
  settings.materials = s.materials;
  settings.model = c.model;
  settings.spring.stiffness_n_mm = 0.5;
  settings.symmetry = s.symmetry;
  settings.symmetry.centre_mm = centre_of(stock.value()->lattice());
  settings.log = true;
  const Vec3 centre(10, 8, 10);
  settings.workspace = Workspace(centre);
  settings.second.tool = BallTool{2};
  settings.second.mode = Mode::deposit;
  settings.second.workspace = Workspace(centre);
  settings.second.spring = settings.spring;
  VirtualDeviceSettings device;
  device.capabilities = arm();
  device.tick_s = 1 / s.rate_hz;
  auto made = LiveCarving::make(
      std::move(stock).value(), std::make_unique<VirtualDevice>(device, along(s, centre, false)),
      settings, both ? std::make_unique<VirtualDevice>(device, along(s, centre, true)) : nullptr);
  ASSERT_TRUE(made.ok()) << made.error();
  LiveCarving& live = *made.value();
  if (c.variant == Variant::protects) {
    ASSERT_TRUE(created.value()->act(protection(s.no_go.front())).ok());
    const auto no_go = no_go_of(*created.value()->worked_on(), 1);
    ASSERT_TRUE(no_go.ok()) << no_go.error();
    WorkedBody body{1, Pose{}, false, no_go.value()};
    live.context().set_body(body);
  }
  uint64_t hash = 0;
  {
    DocumentWriter writer(live, std::move(created).value(), /*forces=*/true);
    live.context().safety().arm();
    const int ticks = static_cast<int>(0.1 * s.rate_hz * static_cast<double>(s.moves.size()));
    for (int k = 0; k < ticks; k++) {
      live.tick(1 / s.rate_hz);
      // Dabs are computed on another thread. This gives it time.
      if (reshapes(c.mode) && k % 10 == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (k % 20 == 0) writer.write();
    }
    live.context().finish_stroke();
    writer.write();
    writer.stop();
    EXPECT_EQ(writer.settled(), "");
    hash = writer.document().worked_on()->content_hash();
    const BodyList& bodies = *writer.document().worked_on();
    EXPECT_EQ(bodies.find(1)->model.content_hash(), live.context().model().content_hash());
    if (changes(c.mode) && !c.refused()) {
      EXPECT_GT(writer.document().steps().size(), 1u);
    }
  }
  expect_true(file, hash);
}

void run(const Case& c) {
  SCOPED_TRACE(c.name());
  Folder folder;
  const std::filesystem::path file = folder.path / "case.kibori";
  switch (c.route) {
    case Route::scene:
      return run_scene(c, file);
    case Route::workpiece:
      return run_workpiece(c, file);
    case Route::servo:
      return run_servo(c, file);
  }
}

class StrokeMatrix : public testing::TestWithParam<Variant> {};

TEST_P(StrokeMatrix, WhatIsKeptReplays) {
  const bool all = std::getenv("KIBORI_MATRIX") != nullptr,
             brief = std::getenv("KIBORI_SHORT") != nullptr;
  const auto v = static_cast<size_t>(GetParam());
  for (size_t m = 0; m < names_of(Mode{}).size(); m++) {
    const auto mode = static_cast<Mode>(m);
    if (brief && (m + v) % 3 != 0) continue;  // each mode meets a third of the variants
    for (size_t i = 0; i < 3; i++)
      for (size_t r = 0; r < 3; r++) {
        // A Latin square: over all modes and variants, each model meets each route.
        if (!all && (i != (m + v) % 3 || r != (m + 2 * v) % 3)) continue;
        run({mode, kModels[i], GetParam(), static_cast<Route>(r)});
      }
  }
}

INSTANTIATE_TEST_SUITE_P(Variants, StrokeMatrix,
                         testing::Values(Variant::plain, Variant::symmetry, Variant::radial,
                                         Variant::two_hands, Variant::protects, Variant::stamp,
                                         Variant::layers, Variant::grain),
                         [](const auto& variant) { return std::string(name_of(variant.param)); });

}  // namespace
}  // namespace kibori::stroke_matrix_tests
