// SPDX-License-Identifier: MIT
// The studio's session: strokes of a pointer reach the model, the document and the surface.
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/run/carving.h>
#include <kibori/report/export.h>
#include <kibori/haptics/materials.h>
#include "apps/studio/session/library.h"
#include <kibori/run/servo_run.h>
#include "apps/studio/session/stock_scene.h"
#include "apps/studio/session/live_session.h"
#include "apps/studio/session/ray_box.h"

#include "tests/support.h"

namespace kibori::studio_tests {
namespace {

using test::Folder;

// No thread moves the tool: a test runs its ticks, and a pointer's positions have their times.
const SessionOptions kByPointer{false, {}, true}, kBySimulatedHand{false, "virtual", true};

// Runs the ticks of a session and counts its time.
class Stepped {
 public:
  explicit Stepped(Session& session) : studio_(*session.live()) {}

  double now_s() const { return 0.001 * static_cast<double>(ticks_); }
  // Runs this much of the servo's time. Calls `see` with the ticks of every frame.
  template <class F>
  void run(double seconds, F&& see) {
    const int64_t until = ticks_ + std::llround(1000 * seconds);
    while (ticks_ < until) {
      for (int i = 0; i < 16 && ticks_ < until; i++, ticks_++) studio_.tick();
      studio_.follow();
      for (const LiveTick& tick : studio_.ticks()) see(tick);
      studio_.history();
    }
  }
  void run(double seconds) {
    run(seconds, [](const LiveTick&) {});
  }
  // Runs until the document's threads have done something; a test cannot step their time. Returns
  // false after 20 seconds or more.
  template <class F>
  bool until(F&& done) {
    for (int i = 0; i < 20000; i++) {
      run(0.008);
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

 private:
  LiveSession& studio_;
  int64_t ticks_ = 0;
};

TEST(Studio, PressedItCutsAndUndoneItIsAsBefore) {
  Folder folder;
  const auto file = folder.path / "a.kibori";
  uint64_t hash = 0;
  {
    auto opened = create_session(file, servo_scene(), kByPointer);
    ASSERT_TRUE(opened.ok()) << opened.error();
    LiveSession& studio = *opened.value()->live();
    Stepped servo(studio);
    const double volume = studio.volume_mm3();
    EXPECT_NEAR(volume, 80 * 50 * 30, 1e-6 * volume);
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 1; }));
    const uint64_t block = studio.history().hash;
    // A ball of 4 mm, pressed 2 mm into the top, along x.
    studio.aim(Vec3(20, 25, 36), Vec3::UnitZ(), servo.now_s());
    servo.run(0.1);
    EXPECT_EQ(studio.removed_mm3(), 0);
    studio.press(Vec3(20, 25, 36), Vec3::UnitZ(), Mode::cut, servo.now_s());
    for (int i = 0; i < 40; i++) {
      studio.aim(Vec3(20 + i, 25, 28), Vec3::UnitZ(), servo.now_s());
      servo.run(0.01);
    }
    servo.run(0.2);
    studio.lift();
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 2; }));
    servo.run(0.2);
    EXPECT_GT(studio.removed_mm3(), 20);
    EXPECT_NEAR(studio.volume_mm3(), volume - studio.removed_mm3(), 0.02 * studio.removed_mm3());
    hash = studio.history().hash;
    EXPECT_NE(hash, block);
    EXPECT_TRUE(studio.history().undo);
    studio.undo();
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 1; }));
    EXPECT_EQ(studio.history().hash, block);
    EXPECT_TRUE(studio.history().redo);
    ASSERT_TRUE(servo.until([&] { return studio.volume_mm3() == volume; }));
    studio.redo();
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 2; }));
    EXPECT_EQ(studio.close(), "");
  }
  auto document = Document::open(file, Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  EXPECT_EQ(document.value()->steps().at(document.value()->head()).hash, hash);
  EXPECT_TRUE(
      document.value()->verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
}

// The user cancels after the pointer was lifted, while the tool still follows the path. Nothing
// remains of this stroke, or of the next one, which waits.
TEST(Studio, ACancelledPathIsNotFollowedFurther) {
  for (const Mode mode : {Mode::cut, Mode::inflate}) {
    Folder folder;
    auto opened = create_session(folder.path / "a.kibori", servo_scene(), kByPointer);
    ASSERT_TRUE(opened.ok()) << opened.error();
    LiveSession& studio = *opened.value()->live();
    Stepped servo(studio);
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 1; }));
    const uint64_t block = studio.history().hash;
    for (const double y : {20, 30}) {
      studio.press(Vec3(20, y, 29), Vec3::UnitZ(), mode, 0);
      for (int i = 1; i <= 100; i++) studio.aim(Vec3(20 + 0.4 * i, y, 28), Vec3::UnitZ(), 0.02 * i);
      studio.lift();
    }
    servo.run(0.05);
    studio.cancel();
    servo.run(3);
    EXPECT_FALSE(studio.pressed());
    // The step of this later stroke shows that the document has handled all earlier requests.
    studio.press(Vec3(20, 25, 36), Vec3::UnitZ(), Mode::cut, 10);
    studio.aim(Vec3(20, 25, 28), Vec3::UnitZ(), 10.1);
    studio.lift();
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 2; }));
    studio.undo();
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 1; }));
    EXPECT_EQ(studio.history().hash, block);
    EXPECT_EQ(studio.history().steps, 2u);
    EXPECT_EQ(studio.close(), "");
  }
}

// The document is closed directly after the pointer was lifted. It has the whole stroke.
TEST(Studio, ClosedItHasTheWholeStroke) {
  for (const Mode mode : {Mode::cut, Mode::inflate}) {
    Folder folder;
    const auto file = folder.path / "a.kibori";
    {
      auto opened = create_session(file, servo_scene(), {});
      ASSERT_TRUE(opened.ok()) << opened.error();
      LiveSession& studio = *opened.value()->live();
      studio.press(Vec3(20, 25, 36), Vec3::UnitZ(), mode, 0);
      for (int i = 1; i <= 40; i++) studio.aim(Vec3(20 + i, 25, 28), Vec3::UnitZ(), 0.01 * i);
      studio.lift();
      EXPECT_EQ(studio.close(), "");
    }
    auto document = Document::open(file, Document::Access::read);
    ASSERT_TRUE(document.ok()) << document.error();
    ASSERT_EQ(document.value()->steps().size(), 2u);
    Vec3 last = Vec3::Zero();
    ASSERT_TRUE(document.value()
                    ->for_ticks(document.value()->head(),
                                [&](const std::vector<RecordedTick>& ticks) -> Status {
                                  last = std::get<MoveTick>(ticks.back().what).tip;
                                  return Ok{};
                                })
                    .ok());
    EXPECT_NEAR((last - Vec3(60, 25, 28)).norm(), 0, mode == Mode::cut ? 0.3 : 1e-9);
  }
}

// The turn of the tool about its axis, shown by a box. The tool turns by the requested angle.
// During a stroke it never turns suddenly, for any direction of the axis.
TEST(Studio, ItTurnsButDoesNotSpin) {
  Folder folder;
  auto opened = create_session(folder.path / "a.kibori", servo_scene(), kByPointer);
  ASSERT_TRUE(opened.ok()) << opened.error();
  LiveSession& studio = *opened.value()->live();
  Stepped servo(studio);
  const auto side = [&] {
    Vec3 last = Vec3::Zero();
    servo.run(0.1, [&](const LiveTick& tick) { last = tick.tool.frame.col(0); });
    return last;
  };
  studio.aim(Vec3(40, 25, 40), Vec3::UnitZ(), servo.now_s());
  EXPECT_NEAR((side() - Vec3::UnitX()).norm(), 0, 1e-6);
  studio.turn(0.5);
  studio.aim(Vec3(40, 25, 40), Vec3::UnitZ(), servo.now_s());
  EXPECT_NEAR((side() - Vec3(std::cos(0.5), std::sin(0.5), 0)).norm(), 0, 1e-6);
  studio.turn(NAN);
  studio.aim(Vec3(40, 25, 40), 5 * Vec3::UnitZ(), servo.now_s());
  EXPECT_NEAR((side() - Vec3(std::cos(0.5), std::sin(0.5), 0)).norm(), 0, 1e-6);
  studio.turn(0);
  // In the air, the axis makes a full turn. The tool turns as far as the axis, and not farther.
  studio.press(Vec3(40, 25, 60), Vec3::UnitZ(), Mode::cut, servo.now_s());
  double turned = 0;
  Mat3 before = Mat3::Identity();
  for (int i = 0; i <= 72; i++) {
    const double angle = 5 * i * std::acos(-1.0) / 180;
    studio.aim(Vec3(40, 25, 60), Vec3(std::sin(angle), 0.02, std::cos(angle)), servo.now_s());
    servo.run(0.02, [&](const LiveTick& tick) {
      turned += rotation_between(before, tick.tool.frame).norm();
      before = tick.tool.frame;
    });
  }
  studio.lift();
  EXPECT_GT(turned, 5);
  EXPECT_LT(turned, 7.5);
}

// Carves with a servo on its own thread, in real time. The threads and pages never wait for each
// other.
TEST(Studio, ByItsOwnThread) {
  Folder folder;
  auto opened = create_session(folder.path / "a.kibori", servo_scene(), {});
  ASSERT_TRUE(opened.ok()) << opened.error();
  LiveSession& studio = *opened.value()->live();
  const auto reaches = [&](StepId step) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      studio.follow();
      studio.ticks();
      if (studio.history().step == step) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  ASSERT_TRUE(reaches(1));
  studio.press(Vec3(20, 25, 36), Vec3::UnitZ(), Mode::cut, 0);
  for (int i = 0; i < 40; i++) studio.aim(Vec3(20 + i, 25, 28), Vec3::UnitZ(), 0.01 * i);
  studio.lift();
  ASSERT_TRUE(reaches(2));
  EXPECT_GT(studio.removed_mm3(), 20);
  studio.undo();
  ASSERT_TRUE(reaches(1));
  EXPECT_EQ(studio.close(), "");
}

// Adds a row of material and waits for its step.
StepId add_row(LiveSession& studio, Stepped& servo, double y) {
  const size_t before = studio.steps().size();
  studio.press(Vec3(15, y, 16), Vec3::UnitZ(), Mode::deposit, servo.now_s());
  servo.run(0.1);
  studio.aim(Vec3(25, y, 16), Vec3::UnitZ(), servo.now_s());
  servo.run(0.2);
  studio.lift();
  EXPECT_TRUE(servo.until([&] { return studio.steps().size() > before; }));
  return studio.steps().empty() ? 0 : studio.steps().back().id;
}

TEST(Studio, HistoryVersionsMaterialsAndPicturesOfSteps) {
  Folder folder;
  const auto file = folder.path / "a.kibori", copy = folder.path / "copy.kibori";
  const Result<Scene> scene = stock_scene(StockBlock{Vec3(40, 30, 16)}, 0.5, 1);
  ASSERT_TRUE(scene.ok()) << scene.error();
  StepId first = 0, branch = 0;
  {
    auto opened = create_session(file, scene.value(), kByPointer);
    ASSERT_TRUE(opened.ok()) << opened.error();
    LiveSession& studio = *opened.value()->live();
    Stepped servo(studio);
    ASSERT_EQ(studio.materials().size(), known_materials().size());
    ASSERT_TRUE(
        servo.until([&] { return studio.history().step == 1 && studio.steps().size() == 1; }));
    const double volume = studio.volume_mm3();
    EXPECT_TRUE(studio.choose_material(2).ok());
    EXPECT_FALSE(studio.choose_material(99).ok());
    first = add_row(studio, servo, 10);
    EXPECT_GT(studio.volume_mm3(), volume + 10);
    EXPECT_LT(studio.steps().back().removed_mm3, -10);
    EXPECT_EQ(studio.steps().back().mode, Mode::deposit);
    ASSERT_TRUE(studio.steps().back().tool.has_value());
    EXPECT_EQ(*studio.steps().back().tool, scene.value().tools.front());
    EXPECT_FALSE(studio.steps().front().tool.has_value());
    EXPECT_GT(studio.steps().back().made_s, 1'700'000'000);
    studio.name_version("one row");
    ASSERT_TRUE(servo.until([&] { return studio.versions().count("one row") == 1; }));
    studio.name_version("7");  // not a name: a number
    std::string reported;
    ASSERT_TRUE(servo.until([&] { return !(reported = studio.notice()).empty(); }));
    EXPECT_NE(reported.find("name"), std::string::npos) << reported;
    studio.go(1);
    ASSERT_TRUE(servo.until([&] { return studio.history().step == 1; }));
    ASSERT_TRUE(servo.until([&] { return studio.volume_mm3() == volume; }));
    branch = add_row(studio, servo, 20);
    EXPECT_EQ(studio.steps().back().parent, 1);
    studio.go(12345);
    ASSERT_TRUE(servo.until([&] { return !studio.notice().empty(); }));
    // Pictures, and a copy: both by the document writer's thread.
    std::atomic<int> answers{0};
    Bytes got;
    studio.keep_thumbnail(first, {1, 2, 3});
    studio.thumbnail(first, [&](Bytes png) {
      got = std::move(png);
      answers++;
    });
    studio.thumbnail(branch, [&](const Bytes& png) {
      EXPECT_TRUE(png.empty());
      answers++;
    });
    studio.save_copy(copy, [&](const Status& saved) {
      EXPECT_TRUE(saved.ok());
      answers++;
    });
    studio.save_copy("/nowhere/x.kibori", [&](const Status& saved) {
      EXPECT_FALSE(saved.ok());
      answers++;
    });
    ASSERT_TRUE(servo.until([&] { return answers == 4; }));
    EXPECT_EQ(got, (Bytes{1, 2, 3}));
    // The models without a spring move the tool where the hand is.
    for (const ForceModel model : {ForceModel::energy, ForceModel::paper, ForceModel::series})
      EXPECT_TRUE(studio.choose_model(model).ok());
    EXPECT_EQ(studio.close(), "");
  }
  for (const auto& path : {file, copy}) {
    EXPECT_FALSE(create_session(path, scene.value(), {}).ok());
    auto again = open_session(path, kByPointer);
    ASSERT_TRUE(again.ok()) << again.error();
    Stepped servo(*again.value());
    EXPECT_EQ(again.value()->materials().size(), known_materials().size());
    ASSERT_TRUE(servo.until([&] { return again.value()->steps().size() == 3; }));
    EXPECT_EQ(again.value()->history().step, branch);
    EXPECT_EQ(again.value()->versions().at("one row"), first);
  }
}

TEST(Studio, ScenesOfStockAlone) {
  const double pi = std::acos(-1.0);
  for (const auto& [shape, exact] :
       {std::pair{StockShape(StockBlock{Vec3(20, 16, 12)}), 20.0 * 16 * 12},
        {StockCylinder{20, 12}, pi * 100 * 12},
        {StockSphere{20}, 4 * pi / 3 * 1000}}) {
    const Result<Scene> scene = stock_scene(shape, 0.25, 3);
    ASSERT_TRUE(scene.ok()) << scene.error();
    const auto model = make_stock(scene.value().stock, "a test", {});
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_NEAR(model.value()->volume_mm3(), exact, 0.01 * exact);
  }
  const double nan = std::nan("");
  for (const Vec3& size :
       {Vec3(0, 1, 1), Vec3(-1, 1, 1), Vec3(nan, 1, 1), Vec3(1e9, 1, 1), Vec3(1, 1, 1e-9)})
    EXPECT_FALSE(stock_scene(StockBlock{size}, 0.1, 0).ok());
  for (const double pitch : {0.0, -1.0, nan, 1e-9, 1e9})
    EXPECT_FALSE(stock_scene(StockBlock{Vec3(10, 10, 10)}, pitch, 0).ok());
  EXPECT_FALSE(stock_scene(StockBlock{Vec3(10, 10, 10)}, 0.1, 60).ok());
  EXPECT_TRUE(file_scene("/nowhere.stl", {10, 100}).ok());  // read when the stock is made
  EXPECT_FALSE(file_scene("/nowhere.png", {10, 100}).ok());
  EXPECT_FALSE(file_scene("/nowhere.stl", {10, 100, 60}).ok());
  for (const double rays : {0.0, 1e9, nan, -5.0})
    EXPECT_FALSE(file_scene("/nowhere.stl", {10, rays}).ok());
  for (const double size : {0.0, 1e9, nan, -5.0})
    EXPECT_FALSE(file_scene("/nowhere.stl", {size, 100}).ok());
}

TEST(Studio, NamesLeadNowhereElse) {
  Folder folder;
  const Library library(folder.path / "documents");
  EXPECT_TRUE(library.list().empty());
  for (const std::string name : {"../x", "/etc/passwd", "..", ".", "", "a/../../b", "x y",
                                 "\\..\\z", ".hidden", "   ", "\x01\x7f", "a\nb"}) {
    const auto place = library.place_for(name);
    ASSERT_TRUE(place.ok()) << place.error();
    EXPECT_EQ(place.value().parent_path(), folder.path / "documents") << name;
    EXPECT_EQ(place.value().extension(), ".kibori");
    EXPECT_NE(place.value().filename().string().front(), '.') << name;
    EXPECT_FALSE(library.find(name).ok()) << name;
  }
  EXPECT_LE(library.place_for(std::string(5000, 'x')).value().filename().string().size(), 120u);
  // Umlauts are not cut in the middle.
  std::string umlauts;
  for (int i = 0; i < 60; i++) umlauts += "\xc3\xa4";
  const std::string kept = library.place_for("a" + umlauts).value().stem().string();
  EXPECT_EQ((kept.size() - 1) % 2, 0u);
  const auto put = [&](const std::string& name) {
    std::ofstream(folder.path / "documents" / name) << "x";
  };
  put("one.kibori");
  put("notes.txt");
  std::filesystem::create_directory(folder.path / "documents" / "folder.kibori");
  ASSERT_EQ(library.list().size(), 1u);
  EXPECT_EQ(library.list().front().name, "one");
  EXPECT_TRUE(library.find("one").ok());
  EXPECT_EQ(library.place_for("one").value().filename(), "one 2.kibori");
  EXPECT_TRUE(library.thumbnail("one").empty());  // not a document
  // Only the exact name: another spelling of the extension is another file.
  put("Old.KIBORI");
  EXPECT_EQ(library.list().size(), 1u);
  EXPECT_FALSE(library.find("Old").ok());
  EXPECT_FALSE(open_session(folder.path / "documents" / "Old.kibori", {}).ok());
  EXPECT_FALSE(std::filesystem::exists(folder.path / "documents" / "Old.kibori"));
  put("locked");
  EXPECT_FALSE(Library(folder.path / "documents" / "locked").place_for("x").ok());
  EXPECT_FALSE(Library({}).place_for("x").ok());
}

TEST(Studio, LayersInOneArchive) {
  Folder folder;
  TriDexel model(make_lattice(Vec3(10, 10, 4), 0.5, 0).value());
  const auto path = folder.path / "layers.zip";
  EXPECT_FALSE(write_layers_zip(path, model.snapshot(), {}).ok());
  EXPECT_FALSE(std::filesystem::exists(path));
  model.fill_block({Vec3(1, 1, 0), Vec3(9, 9, 4)}, 0);
  LayerOptions options;
  options.layer_mm = 1;
  const Status written = write_layers_zip(path, model.snapshot(), options);
  ASSERT_TRUE(written.ok()) << written.error();
  // Checks the archive with Python's zipfile, which shares no code with Kibori.
  const std::string list = folder.path / "list.txt";
  ASSERT_EQ(std::system(("python3 -m zipfile -l " + path.string() + " > " + list).c_str()), 0);
  std::ifstream text(list);
  const std::string all((std::istreambuf_iterator<char>(text)), std::istreambuf_iterator<char>());
  EXPECT_NE(all.find("layer-0001.svg"), std::string::npos) << all;
  EXPECT_EQ(std::system(("python3 -m zipfile -t " + path.string() + " > " + list).c_str()), 0);
}

// A simulated hand holds the tool. It carves when requested, pushes when permitted, and can be
// moved elsewhere.
TEST(Studio, AForceDeviceHoldsTheTool) {
  Folder folder;
  const auto file = folder.path / "a.kibori";
  const Result<Scene> scene = stock_scene(StockBlock{Vec3(40, 30, 16)}, 0.5, 1);
  ASSERT_TRUE(scene.ok()) << scene.error();
  EXPECT_FALSE(create_session(folder.path / "b.kibori", scene.value(), {false, "spoon"}).ok());
  EXPECT_FALSE(
      create_session(folder.path / "b.kibori", scene.value(), {false, "haply", true}).ok());
  auto opened = create_session(file, scene.value(), kBySimulatedHand);
  ASSERT_TRUE(opened.ok()) << opened.error();
  LiveSession& studio = *opened.value()->live();
  Stepped servo(studio);
  ASSERT_NE(studio.held(), nullptr);
  EXPECT_EQ(studio.held()->name, "a simulated hand");
  servo.run(0.3);
  EXPECT_EQ(studio.removed_mm3(), 0);  // not requested
  EXPECT_EQ(studio.held()->safety, SafetyStage::State::off);
  // a pointer has no effect
  studio.press(Vec3(20, 15, 10), Vec3::UnitZ(), Mode::cut, servo.now_s());
  EXPECT_FALSE(studio.pressed());
  // The maximum stiffness depends on the reach.
  const double max = studio.held()->max_n_mm;
  EXPECT_FALSE(studio.choose_hand({200, 1.01 * max, true}).ok());
  EXPECT_FALSE(studio.choose_hand({10, 0, true}).ok());
  EXPECT_FALSE(studio.choose_hand({2000, 0, true}).ok());
  EXPECT_TRUE(studio.choose_hand({100, 0.2 * max, true}).ok());
  EXPECT_NEAR(studio.held()->share, studio.held()->force_n / 100, 1e-9);
  EXPECT_TRUE(studio.choose_reach(2).ok());
  EXPECT_FALSE(studio.choose_reach(25).ok());
  EXPECT_FALSE(studio.choose_reach(0).ok());
  EXPECT_FALSE(studio.choose_reach(NAN).ok());
  EXPECT_TRUE(studio.choose_reach(1).ok());
  studio.work(Mode::cut);
  studio.arm(true);
  EXPECT_TRUE(servo.until([&] { return studio.removed_mm3() > 20; }));
  EXPECT_TRUE(servo.until([&] {
    return studio.held()->safety == SafetyStage::State::on && studio.held()->given_n > 0;
  }));
  studio.arm(false);
  EXPECT_TRUE(servo.until([&] { return studio.held()->safety == SafetyStage::State::off; }));
  EXPECT_EQ(studio.held()->given_n, 0);
  // The hand moves far above the block. Nothing more is cut, and the stroke ends by itself.
  studio.bring(Vec3(20, 15, 60));
  EXPECT_TRUE(servo.until([&] { return studio.history().step >= 2; }));
  servo.run(0.3);
  const double removed = studio.removed_mm3();
  servo.run(0.5);
  EXPECT_EQ(studio.removed_mm3(), removed);
  EXPECT_EQ(studio.close(), "");
}

TEST(Studio, MirroredStrokesAndOneThatIsOnlyLookedAt) {
  Folder folder;
  const auto file = folder.path / "a.kibori";
  const Result<Scene> scene = stock_scene(StockBlock{Vec3(40, 30, 16)}, 0.5, 1);
  ASSERT_TRUE(scene.ok()) << scene.error();
  EXPECT_FALSE(create_session(file, scene.value(), {true, {}}).ok());
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_FALSE(open_session(file, {true, {}}).ok());
  {
    auto opened = create_session(file, scene.value(), kByPointer);
    ASSERT_TRUE(opened.ok()) << opened.error();
    LiveSession& studio = *opened.value()->live();
    Stepped servo(studio);
    ASSERT_TRUE(servo.until([&] { return studio.steps().size() == 1; }));
    EXPECT_TRUE(studio.choose_symmetry({true, false, false}, 1, Axis::z).ok());
    add_row(studio, servo, 10);
    studio.name_version("a row");
    ASSERT_TRUE(servo.until([&] { return studio.versions().size() == 1; }));
    // During carving, another session opens the document and sees the current state.
    auto other = open_session(file, {true, {}});
    ASSERT_TRUE(other.ok()) << other.error();
    Session& looks = *other.value();
    EXPECT_EQ(looks.live(), nullptr);
    EXPECT_EQ(looks.history().step, 2);
    EXPECT_NEAR(looks.volume_mm3(), studio.volume_mm3(), 1);
    EXPECT_EQ(looks.versions().at("a row"), 2);
    looks.undo();
    EXPECT_EQ(looks.history().step, 1);
    EXPECT_FALSE(looks.follow().empty());
    EXPECT_FALSE(looks.history().undo);
    EXPECT_NEAR(looks.volume_mm3(), 40 * 30 * 16, 1);
    looks.undo();
    EXPECT_EQ(looks.history().step, 1);
    looks.redo();
    EXPECT_EQ(looks.history().step, 2);
    looks.go(77);
    EXPECT_FALSE(looks.notice().empty());
    EXPECT_EQ(looks.history().step, 2);
    looks.name_version("mine");
    EXPECT_FALSE(looks.notice().empty());
    bool copied = false;
    looks.save_copy(folder.path / "copy.kibori", [&](const Status& saved) { copied = saved.ok(); });
    EXPECT_TRUE(copied);
    EXPECT_EQ(looks.close(), "");
    EXPECT_EQ(studio.close(), "");
  }
  auto document = Document::open(file, Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  EXPECT_TRUE(document.value()->settings(2).value().symmetry.planes[0]);
  EXPECT_TRUE(
      document.value()->verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
}

// The page's view of the method, against nodes that are tested one by one.
TEST(Studio, RaysNearAPlaceAndTheNodesThatVanishOnThem) {
  test::Random random;
  Lattice lattice;
  lattice.nodes = Index3(37, 24, 51);
  lattice.origin_mm = Vec3(-3, 5, 1);
  lattice.pitch_mm = 0.5;
  const Box all = lattice.to_mm(lattice.whole());
  const auto is_inside = [](const Snapshot& model, Axis axis, int u, int v, int k) {
    bool inside = false;
    model.field(axis).for_spans(u, v, [&](const Span& span) {
      inside |= static_cast<float>(k) + 0.5f >= span.in && static_cast<float>(k) + 0.5f < span.out;
    });
    return inside;
  };
  for (int round = 0; round < 60; round++) {
    TriDexel model(lattice);
    model.fill_block(all, 0);
    Removed removed;
    const auto carve = [&](double radius_mm) {
      const Vec3 from = all.min + random.in_box(0, 1).cwiseProduct(all.size()),
                 by = random.in_box(-2, 2);
      cut(model, SweptTool(BallTool{radius_mm}, Pose{from, Mat3::Identity()}, by, lattice), {},
          removed);
    };
    for (int i = 0; i < 6; i++) carve(1.5);
    const Snapshot before = model.snapshot();
    for (int i = 0; i < 3; i++) carve(2.5);
    const Snapshot now = model.snapshot();
    for (const Axis axis : kAxes) {
      const Vec3 centre = all.min + random.in_box(-0.1, 1.1).cwiseProduct(all.size());
      const double radius = random.uniform(0.2, 14);
      const int every = random.integer(1, 3);
      const RayBox box = ray_box(lattice, axis, centre, radius, every);
      ASSERT_LE(std::max(box.columns, box.rows), kMaxBoxRays);
      ASSERT_TRUE(box.every == every || box.every == 2 * every) << random.note();
      const auto rays = spans_in(box, now);
      ASSERT_EQ(rays.size(), static_cast<size_t>(box.columns * box.rows));
      // For every node of the lattice: is it on the box's rays, and has it vanished?
      size_t count = 0;
      int columns = 0, rows = 0;
      const auto in_cube = [&](int index, int k) {
        const double mm = lattice.origin_mm[index] + lattice.pitch_mm * (k + 0.5);
        return std::abs(mm - centre[index]) <= radius;
      };
      const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
      for (int u = 0; u < lattice.nodes[ui]; u += box.every) columns += in_cube(ui, u);
      for (int v = 0; v < lattice.nodes[vi]; v += box.every) rows += in_cube(vi, v);
      bool deep = false;
      for (int k = 0; k < lattice.nodes[di]; k++) deep |= in_cube(di, k);
      if (deep && columns > 0 && rows > 0) {
        ASSERT_EQ(box.columns, columns) << random.note();
        ASSERT_EQ(box.rows, rows) << random.note();
      }
      for (int v = box.v; v < box.v + box.rows * box.every; v += box.every)
        for (int u = box.u; u < box.u + box.columns * box.every; u += box.every)
          for (int k = 0; k < lattice.nodes[di]; k++)
            count += in_cube(di, k) && is_inside(before, axis, u, v, k) &&
                     !is_inside(now, axis, u, v, k);
      const RayBox more = finer(box);
      EXPECT_EQ(more.every, 1);
      EXPECT_GE(more.columns, box.columns);
      // A box without rows has no columns, either; finer rays may reach it.
      EXPECT_LE(more.columns, box.every * (columns + 1));
      const VanishedNodes gone = vanished_in(box, before, now);
      ASSERT_EQ(gone.count, count) << random.note();
      EXPECT_LE(gone.nodes.size(), kMaxVanishedNodes);
      EXPECT_TRUE(gone.nodes.size() == count || count > kMaxVanishedNodes);
      for (const auto& node : gone.nodes) {
        const int u = node[static_cast<size_t>(ui)], v = node[static_cast<size_t>(vi)],
                  k = node[static_cast<size_t>(di)];
        ASSERT_TRUE(in_cube(di, k) && in_cube(ui, u) && in_cube(vi, v)) << random.note();
        ASSERT_TRUE(is_inside(before, axis, u, v, k) && !is_inside(now, axis, u, v, k))
            << random.note();
      }
    }
  }
  // At any position and size of the cube, the number of rays does not exceed the limit.
  for (const double far : {0.0, 1e12, -1e12})
    for (const double radius : {0.0, 1.0, 1e6}) {
      const RayBox box = ray_box(lattice, Axis::y, Vec3::Constant(far), radius, 64);
      EXPECT_LE(box.columns * box.rows, kMaxBoxRays * kMaxBoxRays);
      EXPECT_LE(finer(box).columns * finer(box).rows, 16 * kMaxBoxRays * kMaxBoxRays);
    }
}

}  // namespace
}  // namespace kibori::studio_tests
