// SPDX-License-Identifier: MIT
// Made by tools/make_protocol.py from protocol/messages.json; edit that file.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <kibori/motion/tool_tick.h>

#include "apps/studio/wire.h"

namespace kibori::studio {

inline constexpr uint16_t kProtocolVersion = 24;

// The first message of a page. key: the page got it from POST /enter, in exchange for the token.
// The studio answers with Welcome or Start. A wrong key closes the connection with code 1008.
struct Hello {
  static constexpr uint8_t kKind = 1;
  uint16_t version = 0;
  std::string key;
  bool in_range() const {
    return key.size() <= 128;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, key);
  }
};
// The requested position of the tool's tip [mm], and the direction of its axis, from the tip into
// the tool. time [s]: when the pointer's event happened, by the page's clock. After Press, the tool
// follows these positions one after another, at their times. pressure: that of a pen, or 1 without
// a pen; see ChooseBrush.
struct Aim {
  static constexpr uint8_t kKind = 2;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  double time = 0;
  double pressure = 0;
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12 &&
           axis.minCoeff() >= -1e+12 && axis.maxCoeff() <= 1e+12 &&
           time >= -1e+12 && time <= 1e+12 &&
           pressure >= 0 && pressure <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, time, pressure);
  }
};
// Begins a stroke at `tip`. If the tool would be inside material there, it begins farther out on
// its axis, clear of material, and then goes in to `tip`. time and pressure: as in Aim.
struct Press {
  static constexpr uint8_t kKind = 3;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  Mode mode = Mode::cut;
  double time = 0;
  double pressure = 0;
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12 &&
           axis.minCoeff() >= -1e+12 && axis.maxCoeff() <= 1e+12 &&
           time >= -1e+12 && time <= 1e+12 &&
           pressure >= 0 && pressure <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, mode, time, pressure);
  }
};
// Ends the stroke, after the tool has followed all poses of Aim.
struct Lift {
  static constexpr uint8_t kKind = 4;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Discards the current stroke.
struct Cancel {
  static constexpr uint8_t kKind = 5;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Goes one step back.
struct Undo {
  static constexpr uint8_t kKind = 6;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Goes one step forward.
struct Redo {
  static constexpr uint8_t kKind = 7;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Sets the tool.
struct ChooseTool {
  static constexpr uint8_t kKind = 8;
  std::string tool;
  bool in_range() const {
    return tool.size() <= 4096;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tool);
  }
};
// The hand's strength [N], 20 to 1000. The stiffness of the spring between hand and tool [N/mm]; 0:
// the default for the pointer or the device. powered: 1 if a motor turns the tool, and the hand
// receives a tenth of the cutting force; 2 if a press drives it, and the hand receives a hundredth.
struct ChooseHand {
  static constexpr uint8_t kKind = 9;
  double strength = 0;
  double stiffness = 0;
  uint8_t powered = 0;
  bool in_range() const {
    return strength >= -1e+12 && strength <= 1e+12 &&
           stiffness >= -1e+12 && stiffness <= 1e+12 &&
           powered <= 2;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(strength, stiffness, powered);
  }
};
// The page has received this frame of chunks and can take the next.
struct Got {
  static constexpr uint8_t kKind = 10;
  uint32_t frame = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(frame);
  }
};
// This page wants to hold the tool. The other pages then watch.
struct TakeTool {
  static constexpr uint8_t kKind = 11;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Makes a new document if none is open. shape: 0 block, 1 log, 2 ball. size [mm]: of its box; x is
// the diameter of the log and the ball, and z is the log's length. pitch [mm]. material: an index
// of Start's materials. If the name is empty, the time becomes the name.
struct Begin {
  static constexpr uint8_t kKind = 12;
  uint8_t shape = 0;
  Vec3 size = Vec3::Zero();
  double pitch = 0;
  uint8_t material = 0;
  std::string name;
  bool in_range() const {
    return shape <= 2 &&
           size.minCoeff() >= -1e+12 && size.maxCoeff() <= 1e+12 &&
           pitch >= -1e+12 && pitch <= 1e+12 &&
           name.size() <= 4096;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(shape, size, pitch, material, name);
  }
};
// Opens one of Start's documents if none is open.
struct Open {
  static constexpr uint8_t kKind = 13;
  std::string name;
  bool in_range() const {
    return name.size() <= 4096;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name);
  }
};
// Saves and closes the document. Start follows.
struct Leave {
  static constexpr uint8_t kKind = 14;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Goes to a step of the history.
struct Go {
  static constexpr uint8_t kKind = 15;
  uint32_t step = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(step);
  }
};
// Names the current step.
struct NameVersion {
  static constexpr uint8_t kKind = 16;
  std::string name;
  bool in_range() const {
    return name.size() <= 4096;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name);
  }
};
// A small picture of a step (PNG, at most 64 kB).
struct KeepThumbnail {
  static constexpr uint8_t kKind = 17;
  uint32_t step = 0;
  std::vector<uint8_t> png;
  bool in_range() const {
    return png.size() <= 1048576;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(step, png);
  }
};
// The material to add: an index of Welcome's materials.
struct ChooseMaterial {
  static constexpr uint8_t kKind = 18;
  uint8_t material = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(material);
  }
};
// The force model.
struct ChooseModel {
  static constexpr uint8_t kKind = 19;
  ForceModel model = ForceModel::series;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(model);
  }
};
// Cancels the job that Work reports.
struct CancelWork {
  static constexpr uint8_t kKind = 20;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Carves one of Start's examples as a new document if none is open.
struct CarveExample {
  static constexpr uint8_t kKind = 21;
  std::string name;
  bool in_range() const {
    return name.size() <= 4096;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name);
  }
};
// Repeats everything that the tool does, symmetrically about the middle of the lattice. planes:
// mirror planes (bits 1 normal to x, 2 to y, 4 to z). fold: the number of repetitions about the
// axis (0 x, 1 y, 2 z) in equal parts of a turn; 1: no repetition.
struct ChooseSymmetry {
  static constexpr uint8_t kKind = 22;
  uint8_t planes = 0;
  uint8_t fold = 0;
  uint8_t axis = 0;
  bool in_range() const {
    return planes <= 7 &&
           fold >= 1 && fold <= 16 &&
           axis <= 2;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(planes, fold, axis);
  }
};
// Chooses what a force device's tool does.
struct ChooseWork {
  static constexpr uint8_t kKind = 23;
  Mode mode = Mode::cut;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(mode);
  }
};
// Permits (1) or forbids (0) that a force device pushes the hand.
struct Arm {
  static constexpr uint8_t kKind = 24;
  uint8_t armed = 0;
  bool in_range() const {
    return armed <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(armed);
  }
};
// Moves a force device's tool to this position [mm], while the hand stays in place.
struct BringTool {
  static constexpr uint8_t kKind = 25;
  Vec3 tip = Vec3::Zero();
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip);
  }
};
// The distance that the tool moves per mm of a force device's hand.
struct ChooseReach {
  static constexpr uint8_t kKind = 26;
  double scale = 0;
  bool in_range() const {
    return scale >= -1e+12 && scale <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(scale);
  }
};
// Carves a scene while the user watches, if no document is open. At the end, the studio sends
// Trace. scene: TOML that names no files. model: the name of a force model; empty: that of the
// scene. pace: 1: the scene's own speed; 4: four times as fast; 0: as fast as possible.
struct RunExperiment {
  static constexpr uint8_t kKind = 27;
  std::string name;
  std::string scene;
  std::string model;
  double pace = 0;
  bool in_range() const {
    return name.size() <= 4096 &&
           model.size() <= 16 &&
           pace >= 0 && pace <= 1000;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name, scene, model, pace);
  }
};
// The tool's rotation about its own axis [rad], from the next position on.
struct ChooseTurn {
  static constexpr uint8_t kKind = 28;
  double turn = 0;
  bool in_range() const {
    return turn >= -1e+06 && turn <= 1e+06;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(turn);
  }
};
// A mallet hits the cutting tool with an energy of 3 J. This drives the tool along its aim.
struct Strike {
  static constexpr uint8_t kKind = 29;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The brush of reshaping modes from the next stroke on. radius [mm]. strength: negative only for
// inflate, crease, pinch and mask. falloff: 0 smooth, 1 linear, 2 constant. keep: 1 if smoothing
// and grabbing keep the volume. red, green, blue: the colour of paint. plane: the plane for
// flatten, trim and build. 0: the plane under the stroke's beginning. 1: the plane under each dab.
// 2: the plane through `point` [mm] with `normal`. wall: for throw, the distance to a second finger
// on the other side of the wall [mm]; 0: there is no second finger. mask: what the mode mask does:
// 0 paint, 1 invert, 2 blur, 3 cavity, 4 height, 5 material. mask_material: the number of a
// material for 5. alpha: the texture of the brush, as an index in the list ALPHAS of kinds.ts; The
// entry `picture` is the picture of ChooseTexture; without such a picture, there is no texture.
// pressure: what the pressure of a pen changes: 0 nothing, 1 the size, 2 the strength, 3 both.
struct ChooseBrush {
  static constexpr uint8_t kKind = 30;
  double radius = 0;
  double strength = 0;
  uint8_t falloff = 0;
  uint8_t keep = 0;
  uint8_t red = 0;
  uint8_t green = 0;
  uint8_t blue = 0;
  uint8_t plane = 0;
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();
  double wall = 0;
  uint8_t mask = 0;
  uint8_t mask_material = 0;
  uint8_t alpha = 0;
  uint8_t pressure = 0;
  bool in_range() const {
    return radius >= 1e-06 && radius <= 1e+06 &&
           strength >= -1 && strength <= 1 &&
           falloff <= 2 &&
           keep <= 1 &&
           plane <= 2 &&
           point.minCoeff() >= -1e+12 && point.maxCoeff() <= 1e+12 &&
           normal.minCoeff() >= -1 && normal.maxCoeff() <= 1 &&
           wall >= 0 && wall <= 1e+06 &&
           mask <= 5 &&
           mask_material <= 63 &&
           alpha <= 13 &&
           pressure <= 3;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(radius, strength, falloff, keep, red, green, blue, plane, point, normal, wall, mask, mask_material, alpha, pressure);
  }
};
// Asks for the rays of one field (axis 0 x, 1 y, 2 z) near a position [mm]. The rays are in a cube
// with half side `radius`. every: 1 for all of these rays, n for every n-th in both directions. The
// studio answers once with Method, at least 33 ms after its last answer. A newer request replaces a
// request that waits.
struct AskMethod {
  static constexpr uint8_t kKind = 31;
  uint8_t axis = 0;
  Vec3 centre = Vec3::Zero();
  double radius = 0;
  uint8_t every = 0;
  bool in_range() const {
    return axis <= 2 &&
           centre.minCoeff() >= -1e+12 && centre.maxCoeff() <= 1e+12 &&
           radius >= 0 && radius <= 1e+06 &&
           every >= 1 && every <= 64;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(axis, centre, radius, every);
  }
};
// Runs an action on bodies as a step, in the form of documents: {"verb":"join","bodies":[1,2]}.
struct ActOnBodies {
  static constexpr uint8_t kKind = 32;
  std::string action;
  bool in_range() const {
    return action.size() >= 2 && action.size() <= 65536;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(action);
  }
};
// Makes a body the active one, which strokes change.
struct ChooseBody {
  static constexpr uint8_t kKind = 33;
  uint32_t body = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(body);
  }
};
// The rule for pieces that a stroke cuts off. 0: a piece below a tenth of the piece that it came
// from falls away, and a larger one becomes a body. 1: all stay. 2: all fall away. 3: all become
// bodies.
struct ChooseCrumbs {
  static constexpr uint8_t kKind = 34;
  uint8_t rule = 0;
  bool in_range() const {
    return rule <= 3;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(rule);
  }
};
// Switches colours on (1) or off (0) that show the distance of the active body's surface from the
// protected region. Remains reports the numbers.
struct ShowRemains {
  static constexpr uint8_t kKind = 35;
  uint8_t shown = 0;
  bool in_range() const {
    return shown <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(shown);
  }
};
// Shows the result of an action, without a step in the history. action: as in ActOnBodies; empty:
// ends the preview. The studio answers with Previewed.
struct PreviewAction {
  static constexpr uint8_t kKind = 36;
  std::string action;
  bool in_range() const {
    return action.size() <= 65536;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(action);
  }
};
// Replaces the action of the earlier step `step`, which is on the path to the step `head`. action:
// as in ActOnBodies. The studio adds a new step next to the old one. After the new step, it repeats
// the later steps up to `head`.
struct ReviseStep {
  static constexpr uint8_t kKind = 37;
  uint32_t step = 0;
  uint32_t head = 0;
  std::string action;
  bool in_range() const {
    return action.size() >= 2 && action.size() <= 65536;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(step, head, action);
  }
};
// The second hand's tool, and its mode while it is pressed: cut, deposit or touch; off: there is no
// second hand. Its strokes use the guide and the string of ChooseGuide. lead, entry, lift: as in
// ChooseGuide, but for this tool.
struct ChooseSecond {
  static constexpr uint8_t kKind = 38;
  std::string tool;
  Mode mode = Mode::cut;
  uint8_t lead = 0;
  double entry = 0;
  double lift = 0;
  bool in_range() const {
    return tool.size() <= 4096 &&
           lead <= 1 &&
           entry >= 0 && entry <= 1e+06 &&
           lift >= 0 && lift <= 1e+06;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tool, mode, lead, entry, lift);
  }
};
// Presses the second hand's tool at `tip`, as in Press. While the first hand works, the second hand
// joins its stroke. time: as in Aim.
struct PressSecond {
  static constexpr uint8_t kKind = 39;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  double time = 0;
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12 &&
           axis.minCoeff() >= -1e+12 && axis.maxCoeff() <= 1e+12 &&
           time >= -1e+12 && time <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, time);
  }
};
// The requested pose of the second hand's tool, as in Aim.
struct AimSecond {
  static constexpr uint8_t kKind = 40;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  double time = 0;
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12 &&
           axis.minCoeff() >= -1e+12 && axis.maxCoeff() <= 1e+12 &&
           time >= -1e+12 && time <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, time);
  }
};
// Lifts the second hand after its tool has followed all aims.
struct LiftSecond {
  static constexpr uint8_t kKind = 41;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// How the strokes of the pointer behave, from the next stroke on. guide: 0: none. 1: a straight
// line; its direction is a multiple of `snap` [degrees], or any direction if `snap` is 0. 2: a
// circle about `centre` [mm]. 3: the curve through the points of `curve` (three f64 each [mm]);
// closed: 1 if the curve is closed. steady: the length of the string that pulls the tool behind the
// hand [mm]. lead: the tool's local x axis turns to its path; it starts `lift` [mm] above the wood,
// goes in over `entry` [mm] of path, and comes out in the same way. stamp: the tool is pressed in
// from `lift` above the wood: once where the stroke begins, or every `every` mm along its path if
// `every` is not 0.
struct ChooseGuide {
  static constexpr uint8_t kKind = 42;
  uint8_t guide = 0;
  double snap = 0;
  Vec3 centre = Vec3::Zero();
  uint8_t closed = 0;
  double steady = 0;
  uint8_t lead = 0;
  double entry = 0;
  double lift = 0;
  uint8_t stamp = 0;
  double every = 0;
  std::vector<uint8_t> curve;
  bool in_range() const {
    return guide <= 3 &&
           snap >= 0 && snap <= 180 &&
           centre.minCoeff() >= -1e+12 && centre.maxCoeff() <= 1e+12 &&
           closed <= 1 &&
           steady >= 0 && steady <= 1e+06 &&
           lead <= 1 &&
           entry >= 0 && entry <= 1e+06 &&
           lift >= 0 && lift <= 1e+06 &&
           stamp <= 1 &&
           every >= 0 && every <= 1e+06 &&
           curve.size() <= 240000;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(guide, snap, centre, closed, steady, lead, entry, lift, stamp, every, curve);
  }
};
// Asks for the mass of the active body. The studio answers with Mass.
struct AskMass {
  static constexpr uint8_t kKind = 43;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Chooses a stamp. what: 0 letters, 1 a picture, 2 a mesh. Letters: `text` in a `font` (a family);
// `size` is the height of a capital H, and `depth` the length of the letters [mm]. A picture (PNG)
// is a relief of width `size`. White parts are `depth` deeper than black parts; if `invert` is 1,
// black parts are deeper. A mesh: its longer horizontal side is `size`. name: the file's name.
// data: its bytes. ShowStamp reports the result.
struct ChooseStamp {
  static constexpr uint8_t kKind = 44;
  uint8_t what = 0;
  std::string text;
  std::string font;
  double size = 0;
  double depth = 0;
  uint8_t invert = 0;
  std::string name;
  std::vector<uint8_t> data;
  bool in_range() const {
    return what <= 2 &&
           text.size() <= 1024 &&
           font.size() <= 256 &&
           size >= 0.1 && size <= 1000 &&
           depth >= 0.1 && depth <= 1000 &&
           invert <= 1 &&
           name.size() <= 256 &&
           data.size() <= 1000000;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(what, text, font, size, depth, invert, name, data);
  }
};
// Asks for the fonts that are installed on the studio's machine. The studio answers with Fonts.
struct AskFonts {
  static constexpr uint8_t kKind = 45;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Switches colours on (1) or off (0) that show printing faults of the active body. They replace
// those of ShowRemains. The faults are walls thinner than `wall` [mm], faces that look down and
// lean from upright by more than `overhang` [degrees], loose pieces. PrintFaults reports the
// numbers.
struct ShowFaults {
  static constexpr uint8_t kKind = 46;
  uint8_t shown = 0;
  double wall = 0;
  double overhang = 0;
  bool in_range() const {
    return shown <= 1 &&
           wall >= 0.01 && wall <= 1000 &&
           overhang >= 0 && overhang <= 90;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(shown, wall, overhang);
  }
};
// Carves a document of the library again with another pitch [mm], into a new document, and opens
// that. No document may be open.
struct ChangeDetail {
  static constexpr uint8_t kKind = 47;
  std::string document;
  double pitch = 0;
  bool in_range() const {
    return document.size() <= 256 &&
           pitch >= 1e-06 && pitch <= 1e+06;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(document, pitch);
  }
};
// Plays the milling job, or pauses it. speed: seconds of the machine per second; 0: as fast as
// possible. stops: 1 if it stops at collisions.
struct PlayProgram {
  static constexpr uint8_t kKind = 48;
  uint8_t playing = 0;
  double speed = 0;
  uint8_t stops = 0;
  bool in_range() const {
    return playing <= 1 &&
           speed >= 0 && speed <= 100000 &&
           stops <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(playing, speed, stops);
  }
};
// Goes to a time of the milling job [s]. If this time is not computed yet, goes to the last computed time.
struct SeekProgram {
  static constexpr uint8_t kKind = 49;
  double time = 0;
  bool in_range() const {
    return time >= 0 && time <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(time);
  }
};
// forward 1: goes to the end of the next line that moves the tool. forward 0: goes to the beginning
// of the current line.
struct StepProgram {
  static constexpr uint8_t kKind = 50;
  uint8_t forward = 0;
  bool in_range() const {
    return forward <= 1;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(forward);
  }
};
// Goes to the end of a line's first execution. program: its index in Playback. line: from 1. If the
// line is not computed yet, the studio waits until it is.
struct GoToLine {
  static constexpr uint8_t kKind = 51;
  uint32_t program = 0;
  uint32_t line = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(program, line);
  }
};
// Runs the milling job into a new document, and opens that. If the name is empty, the job's name is used.
struct KeepProgram {
  static constexpr uint8_t kKind = 52;
  std::string name;
  bool in_range() const {
    return name.size() <= 400;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name);
  }
};
// The picture (PNG, at most 1024 pixels on a side) for the texture `picture` of brushes. Black has
// no effect, white the full effect. name: the file's name, for messages.
struct ChooseTexture {
  static constexpr uint8_t kKind = 53;
  std::string name;
  std::vector<uint8_t> data;
  bool in_range() const {
    return name.size() <= 256 &&
           data.size() <= 1000000;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name, data);
  }
};
// A document is open. origin, nodes, pitch: the base of its lattice, with the lower corner and the
// pitch in mm. The lattice may have grown beyond it. rate: of the servo [Hz]. document: its name.
// materials: JSON (name, color, rings: their contrast, 0 to 1). material: the index of the stock's
// material. page: the page's id in HTTP requests. what: 0: a document that can be carved; 1: a
// document that is open read-only; 2: an experiment; 3: a milling job that is played back. The page
// must discard everything that it showed before.
struct Welcome {
  static constexpr uint8_t kKind = 64;
  uint16_t version = 0;
  Vec3 origin = Vec3::Zero();
  Vec3 nodes = Vec3::Zero();
  double pitch = 0;
  double rate = 0;
  std::string document;
  std::string materials;
  uint8_t material = 0;
  std::string page;
  uint8_t what = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, origin, nodes, pitch, rate, document, materials, material, page, what);
  }
};
// The changed surface of one body. The page answers Got. Each chunk: position x y z (i16), numbers
// of vertices and triangles (u32), a flag (u16; 1: a vertex is painted or masked), vertices,
// corners (u16 each). If the flag is 1, a colour per vertex follows: red, green, blue, and 255 - m
// if painted, else m, with the mask m from 0 to 127 (u8 each). A vertex: x y z (u16 each, in 1/2048
// of the pitch), normal (3 x i8, 1/127), material (u8). The coordinates of its vertices are
// relative to the point that is (16 * position - 1) cells from the lattice's origin.
struct Chunks {
  static constexpr uint8_t kKind = 65;
  uint32_t frame = 0;
  uint8_t more = 0;
  uint32_t body = 0;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(frame, more, body, data);
  }
};
// Every servo tick since the last Ticks message, fifteen f32 for each tick. If a page has too many
// unread bytes, it misses messages; `start` shows the gap. A tick has: tip [mm], force of the wood
// on the tool [N], moment about the tip [N mm]; the third (axis) and first column of the tool's
// frame. start: the number of the first.
struct Ticks {
  static constexpr uint8_t kKind = 66;
  double start = 0;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(start, data);
  }
};
// volume: of the bodies [mm^3]. removed: the volume of the stock minus `volume` [mm^3]. step: the
// current one. holds: 1 if this page holds the tool. blocked: 1 if the pressed tool is inside
// material and cannot back out. pending: how far the model is behind the hand in a brush's stroke,
// as a time of the hand's motion [s]. For a force device: safety (0 off, 1 waits until the computed
// force is small, 2 on), trip (why it is off), given (its force [N]).
struct State {
  static constexpr uint8_t kKind = 67;
  double volume = 0;
  double removed = 0;
  uint32_t step = 0;
  uint32_t steps = 0;
  uint8_t undo = 0;
  uint8_t redo = 0;
  uint8_t holds = 0;
  uint8_t blocked = 0;
  double pending = 0;
  std::string hash;
  uint8_t safety = 0;
  std::string trip;
  double given = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(volume, removed, step, steps, undo, redo, holds, blocked, pending, hash, safety, trip, given);
  }
};
// A sentence for the user.
struct Notice {
  static constexpr uint8_t kKind = 68;
  std::string text;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(text);
  }
};
// No document is open. JSON: documents (name, changed: s since 1970, bytes), materials (as in
// Welcome), examples (name, about).
struct Start {
  static constexpr uint8_t kKind = 69;
  uint16_t version = 0;
  uint8_t holds = 0;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, holds, json);
  }
};
// The steps that this page does not have yet, in the order of their numbers. Each has its number
// and its parent's or 0 (u32 each), and the removed volume [mm^3] (f32). Then the time of its
// beginning [s since 1970] (f64; 0: unknown), the tool (text, as JSON; null: none), mode (u8; off:
// the tool only moved), 1 if a thumbnail is stored, else 0 (u8), label (text).
struct Steps {
  static constexpr uint8_t kKind = 70;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(data);
  }
};
// JSON: the step number of each name.
struct Versions {
  static constexpr uint8_t kKind = 71;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json);
  }
};
// A job that may take long is running. what: its name for the user; empty: no job runs. share: its
// progress, 0 to 1; below 0: unknown.
struct Work {
  static constexpr uint8_t kKind = 72;
  std::string what;
  double share = 0;
  uint8_t cancellable = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(what, share, cancellable);
  }
};
// The force device that holds the tool. Sent after Welcome, and when its reach or the hand changes:
// its name, max force [N] (0: none), rendered stiffness and max stiffness [N/mm, at the hand], the
// reach, and the share of the wood's force at the hand.
struct Device {
  static constexpr uint8_t kKind = 73;
  std::string name;
  double force = 0;
  double stiffness = 0;
  double max = 0;
  double scale = 0;
  double share = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(name, force, stiffness, max, scale, share);
  }
};
// The result of an experiment. JSON: run (a unique number), name, model, finished, ticks,
// removed_mm3, mean_force_N (over ticks with a force), max_force_N, max_moment_Nmm, step_us, marks
// (label, time_s). data: at most 100 000 rows of seven f32: time [s], force [N], moment [N mm]. If
// there are more ticks, each row is the one with the largest force of several successive ticks.
struct Trace {
  static constexpr uint8_t kKind = 74;
  std::string json;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json, data);
  }
};
// The current tool: that of an experiment, or that of the page that holds the tool.
struct ShowTool {
  static constexpr uint8_t kKind = 75;
  std::string tool;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tool);
  }
};
// Answers AskMethod from the newest snapshot. The rays are u, u + every, ... (columns of them) by
// v, v + every, ... (rows of them) of the field, at most 32 in each direction. If there would be
// more, every is larger than requested. spans: for each ray the number of spans (u8, at most 16),
// and the ends in and out of each span (f32). u changes fastest from ray to ray. Only spans between
// the depths low and high [lattice units] are listed. vanished: nodes x y z (i16 each) between
// these depths that were in the material at this page's last answer and are not now. They are on
// these rays and on rays between them: on four times as many rays in each direction, or on all rays
// if there are fewer. The list has at most 2048 nodes, evenly chosen. gone: the number of all. For
// the newest tick that removed or added points: points (K: their number in the whole model), volume
// (removed [mm^3]), motion (of the tool's tip [mm]), force (of the wood on the tool [N]). ticks:
// the number of ticks since the last answer. taken: the sum of their K.
struct Method {
  static constexpr uint8_t kKind = 76;
  uint8_t axis = 0;
  uint16_t every = 0;
  double u = 0;
  double v = 0;
  uint16_t columns = 0;
  uint16_t rows = 0;
  double low = 0;
  double high = 0;
  uint32_t gone = 0;
  double points = 0;
  double volume = 0;
  Vec3 motion = Vec3::Zero();
  Vec3 force = Vec3::Zero();
  uint32_t ticks = 0;
  double taken = 0;
  std::vector<uint8_t> spans;
  std::vector<uint8_t> vanished;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(axis, every, u, v, columns, rows, low, high, gone, points, volume, motion, force, ticks, taken, spans, vanished);
  }
};
// All bodies. active: the id of the active body. JSON: for each body id, name, pose (of the body's
// lattice in the world: its origin [mm], then the columns of its frame), visible, locked, no_go,
// volume_mm3. Chunks of a body that is gone, hidden or moved are invalid. Chunks of a newly shown
// body follow.
struct Bodies {
  static constexpr uint8_t kKind = 77;
  uint32_t active = 0;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(active, json);
  }
};
// The numbers for ShowRemains. max, mean: the maximum and mean distance [mm] of the active body's
// surface from the protected region. volume: the volume of the body outside that region [mm^3].
// scale: the distance of the last colour [mm]; 0: there is no protected region, and no colours are
// shown.
struct Remains {
  static constexpr uint8_t kKind = 78;
  double max = 0;
  double mean = 0;
  double volume = 0;
  double scale = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(max, mean, volume, scale);
  }
};
// Answers PreviewAction. error: a sentence; empty: no error. forces: JSON. For a spline, it has a
// force [N] for each control point: the force of soft clay on a finger that moved this point since
// the last preview.
struct Previewed {
  static constexpr uint8_t kKind = 79;
  std::string error;
  std::string forces;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(error, forces);
  }
};
// The second hand's tool at the newest tick: tip [mm], the third (axis) and first column of its
// frame, and the force of the wood on it [N]. there: 0 if there is no second hand.
struct SecondHand {
  static constexpr uint8_t kKind = 80;
  uint8_t there = 0;
  std::string tool;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  Vec3 side = Vec3::Zero();
  Vec3 force = Vec3::Zero();
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(there, tool, tip, axis, side, force);
  }
};
// Answers AskMass: the body, its volume [mm^3], its mass [g] (0: the density of one of its
// materials is unknown), its centre of gravity [mm] in the world, and the memory of all bodies
// [bytes].
struct Mass {
  static constexpr uint8_t kKind = 81;
  uint32_t body = 0;
  double volume = 0;
  double mass = 0;
  Vec3 centre = Vec3::Zero();
  double memory = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(body, volume, mass, centre, memory);
  }
};
// The triangles of the current stamp in its own frame [mm], with the tip at the origin: vertices
// (three f32 each) and triangles of their indices (three u32 each).
struct ShowStamp {
  static constexpr uint8_t kKind = 82;
  std::vector<uint8_t> vertices;
  std::vector<uint8_t> triangles;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(vertices, triangles);
  }
};
// Answers AskFonts. JSON: the families in alphabetical order.
struct Fonts {
  static constexpr uint8_t kKind = 83;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json);
  }
};
// The numbers for ShowFaults. overhang, thin: areas of overhanging and of thin walls; area: of the
// whole surface [mm^2]. thinnest: thickness of the thinnest wall [mm], 0 without one. pieces: the
// number of pieces; all but the largest are loose.
struct PrintFaults {
  static constexpr uint8_t kKind = 84;
  double overhang = 0;
  double thin = 0;
  double area = 0;
  double thinnest = 0;
  uint32_t pieces = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(overhang, thin, area, thinnest, pieces);
  }
};
// The milling job. JSON: programs (name, lines), collisions (kind, program, line, tool, time: its
// end [s], volume_mm3), warnings and error (sentences). Sent after Welcome, and when it changes.
struct Playback {
  static constexpr uint8_t kKind = 85;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json);
  }
};
// The moment of a milling job that is shown. time: of the job [s]. computed: the job is computed up
// to this time [s]. done: 1 if the whole job is computed. share: progress of computing, 0 to 1.
// playing, speed, stops: as in PlayProgram. program, line: as in GoToLine; line 0: before the first
// move. tool: its number; 0: none. rapid: 1 if it is a rapid move. force [N], power [W]: the
// maximum during the move; 0: unknown. stopped: the index of the collision at which the playback
// stopped; -1: none.
struct Played {
  static constexpr uint8_t kKind = 86;
  double time = 0;
  double computed = 0;
  uint8_t done = 0;
  double share = 0;
  uint8_t playing = 0;
  double speed = 0;
  uint8_t stops = 0;
  uint32_t program = 0;
  uint32_t line = 0;
  uint32_t tool = 0;
  uint8_t rapid = 0;
  double force = 0;
  double power = 0;
  double stopped = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(time, computed, done, share, playing, speed, stops, program, line, tool, rapid, force, power, stopped);
  }
};
// The first message that a reader of --publish HOST:PORT receives. It is sent again when another
// document is opened. Readers send nothing. The JSON describes the rows of PublishedTicks: their
// size (row_bytes) and their columns (name, type, offset in bytes, count).
struct PublishedAbout {
  static constexpr uint8_t kKind = 96;
  uint16_t version = 0;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, json);
  }
};
// Every servo tick since the last such message: rows of PublishedAbout's row_bytes, one per hand.
struct PublishedTicks {
  static constexpr uint8_t kKind = 97;
  std::vector<uint8_t> rows;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(rows);
  }
};

// The messages that a page may send.
using FromPage = std::variant<Hello, Aim, Press, Lift, Cancel, Undo, Redo, ChooseTool, ChooseHand, Got, TakeTool, Begin, Open, Leave, Go, NameVersion, KeepThumbnail, ChooseMaterial, ChooseModel, CancelWork, CarveExample, ChooseSymmetry, ChooseWork, Arm, BringTool, ChooseReach, RunExperiment, ChooseTurn, Strike, ChooseBrush, AskMethod, ActOnBodies, ChooseBody, ChooseCrumbs, ShowRemains, PreviewAction, ReviseStep, ChooseSecond, PressSecond, AimSecond, LiftSecond, ChooseGuide, AskMass, ChooseStamp, AskFonts, ShowFaults, ChangeDetail, PlayProgram, SeekProgram, StepProgram, GoToLine, KeepProgram, ChooseTexture>;

}  // namespace kibori::studio
