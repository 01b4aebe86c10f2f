// SPDX-License-Identifier: MIT
// Made by tools/make_protocol.py from protocol/messages.json: change that.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <kibori/motion/tool_tick.h>

#include "apps/studio/wire.h"

namespace kibori::studio {

inline constexpr uint16_t kProtocolVersion = 18;

// The first message of a page, with the key that POST /enter gave for the token. Welcome or Start
// answers; where the key is another one, the line is closed with code 1008.
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
// Where the tool's tip is wanted [mm], and its axis, from the tip up; time [s] of the pointer's
// event, by the page's clock. After Press the tool follows these places one after another, as their
// times say.
struct Aim {
  static constexpr uint8_t kKind = 2;
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
// A stroke begins at `tip`: the tool backs out from there along its axis until it is clear of
// material, and comes in again. time: as of Aim.
struct Press {
  static constexpr uint8_t kKind = 3;
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::Zero();
  Mode mode = Mode::cut;
  double time = 0;
  bool in_range() const {
    return tip.minCoeff() >= -1e+12 && tip.maxCoeff() <= 1e+12 &&
           axis.minCoeff() >= -1e+12 && axis.maxCoeff() <= 1e+12 &&
           time >= -1e+12 && time <= 1e+12;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tip, axis, mode, time);
  }
};
// The stroke is over, once the tool has been everywhere that it was aimed to.
struct Lift {
  static constexpr uint8_t kKind = 4;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The stroke that is being made is as if it had not been.
struct Cancel {
  static constexpr uint8_t kKind = 5;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// One step back.
struct Undo {
  static constexpr uint8_t kKind = 6;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// One step forth.
struct Redo {
  static constexpr uint8_t kKind = 7;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The tool that is held from now on.
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
// The hand's strength [N], 20 to 1000; the stiffness between hand and tool [N/mm], 0: what suits a
// pointer or the device; powered: 1 where a motor turns the tool, and the hand bears a tenth of the
// cut; 2 where a press drives it, and the hand bears a hundredth.
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
// The page has taken this frame of chunks in, and can take the next.
struct Got {
  static constexpr uint8_t kKind = 10;
  uint32_t frame = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(frame);
  }
};
// This page wants to hold the tool; the others then watch.
struct TakeTool {
  static constexpr uint8_t kKind = 11;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// A new document, where none is open. shape: 0 block, 1 log, 2 ball. size [mm]: of its box; the
// log's and the ball's diameter is x, the log's length z. pitch [mm]. material: a number of
// Start's. An empty name: the time.
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
// One of Start's documents, where none is open.
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
// The document is saved and closed; Start follows.
struct Leave {
  static constexpr uint8_t kKind = 14;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// To a step of the history.
struct Go {
  static constexpr uint8_t kKind = 15;
  uint32_t step = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(step);
  }
};
// Gives the step where the document stands a name.
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
// A small picture of a step (PNG, 64 kB at most).
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
// What is added: a number of Welcome's materials.
struct ChooseMaterial {
  static constexpr uint8_t kKind = 18;
  uint8_t material = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(material);
  }
};
// How motion becomes force.
struct ChooseModel {
  static constexpr uint8_t kKind = 19;
  ForceModel model = ForceModel::series;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(model);
  }
};
// What Work tells of is not to be.
struct CancelWork {
  static constexpr uint8_t kKind = 20;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// One of Start's examples is carved as a new document, where none is open.
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
// Where all that the tool does is done again, about the lattice's middle: planes in which it is
// mirrored (bits 1 normal to x, 2 to y, 4 to z), and how many times it goes around the axis (0 x, 1
// y, 2 z) in equal parts of a turn; 1: no more than itself.
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
// What a force device's tool does.
struct ChooseWork {
  static constexpr uint8_t kKind = 23;
  Mode mode = Mode::cut;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(mode);
  }
};
// Lets a force device push (1) or not (0).
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
// A force device's tool is here from now on [mm], wherever the hand is.
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
// How far the tool goes for a mm of a force device's hand.
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
// A scene (TOML, without files) is carved to be looked at, where nothing is open; Trace follows.
// model: its name, or empty: as the scene says. pace: 1 the scene's own time, 4 four times as fast,
// 0 as fast as it goes.
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
// How far the tool is turned about its own axis from the next place on [rad].
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
// A blow of a mallet (3 J) on the tool that cuts: it is driven on along its aim.
struct Strike {
  static constexpr uint8_t kKind = 29;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// The brush of modes that reshape, from the next stroke on: radius [mm]; strength, below 0 for
// inflate only; falloff 0 smooth, 1 linear, 2 constant; keep: 1 where smoothing and grabbing keep
// the volume; the colour of paint; and what flatten goes to: plane 0 that under the stroke's
// beginning, 1 that under each dab, 2 the one through the point [mm] with that normal; of thrown
// clay, how far a second finger stands across the wall [mm], 0: there is none.
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
  bool in_range() const {
    return radius >= 1e-06 && radius <= 1e+06 &&
           strength >= -1 && strength <= 1 &&
           falloff <= 2 &&
           keep <= 1 &&
           plane <= 2 &&
           point.minCoeff() >= -1e+12 && point.maxCoeff() <= 1e+12 &&
           normal.minCoeff() >= -1 && normal.maxCoeff() <= 1 &&
           wall >= 0 && wall <= 1e+06;
  }
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(radius, strength, falloff, keep, red, green, blue, plane, point, normal, wall);
  }
};
// What the rays of one field (axis 0 x, 1 y, 2 z) find near a place [mm]: in the cube of that half
// side, every so-manyth ray both ways. Method answers once, no sooner than 33 ms after the last
// answer; a newer question takes the place of one that waits.
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
// What is done with bodies, as a step, as documents keep it: {"verb":"join","bodies":[1,2]}.
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
// The body that strokes go to from now on.
struct ChooseBody {
  static constexpr uint8_t kKind = 33;
  uint32_t body = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(body);
  }
};
// What becomes of pieces that a stroke severs: 0 those under a tenth fall away and larger ones
// become bodies, 1 they stay, 2 fall away, 3 become bodies.
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
// Whether the body that is worked on is shown in colours that tell how far its surface is from what
// is no-go; Remains tells the numbers.
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
// What this would come to is shown from now on, and is no step; text as of ActOnBodies, or empty:
// no more. Previewed answers.
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
// What was done with bodies in a step, on the way to head, is done otherwise: text as of
// ActOnBodies. A new step beside it, and what followed up to head done again after it.
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
// The second hand's tool from now on, and what it does while it is pressed: cut, deposit or touch;
// off: there is no second hand. Its pointer's strokes have the guide and the string of ChooseGuide;
// lead, entry, lift: as there, of this tool.
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
// The second hand's tool comes in at `tip`, as of Press; while the first works, in its stroke.
// time: as of Aim.
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
// Where the second hand's tool is wanted, as of Aim.
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
// The second hand lets go, once its tool has been everywhere that it was aimed to.
struct LiftSecond {
  static constexpr uint8_t kKind = 41;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// How the pointer's strokes behave from the next one on. guide: 0 none, 1 a straight line, whose
// direction is a multiple of snap [degrees] (0: any), 2 a circle about the centre [mm], 3 the curve
// through these points (three f64 each [mm]), closed or not. steady: the tool is drawn behind the
// hand on a string so long [mm]. lead: its local x axis turns to the way it goes; it goes in and
// comes out over `entry` [mm], from `lift` [mm] above. stamp: it is pressed in, from `lift` above,
// where the stroke begins, or, where `every` is not 0, at so many mm from each other on its way.
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
// What the body that is worked on weighs; Mass answers.
struct AskMass {
  static constexpr uint8_t kKind = 43;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// A stamp is held from now on. what: 0 letters: `text` in a `font` (a family), `size` [mm] high as
// a capital H, `depth` long; 1 a picture (PNG) as a relief, `size` wide, white `depth` deeper than
// black, or, inverted, black deeper; 2 a mesh, `size` wide as the longer of its sides. name: the
// file's, data: its bytes. ShowStamp tells what it is.
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
// Which fonts are installed where the studio runs; Fonts answers.
struct AskFonts {
  static constexpr uint8_t kKind = 45;
  template <class F>
  void fields([[maybe_unused]] F&& f) {}
};
// Whether the body that is worked on is shown in colours that tell what a printer would fail at (1;
// no longer what ShowRemains asked for): walls thinner than `wall` [mm], faces that look down and
// lean from upright by more than `overhang` [degrees], loose pieces. PrintFaults tells the numbers.
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
// A document is open: the lattice (lower corner [mm], nodes, pitch [mm]), the servo's rate [Hz],
// the document's name, its materials (JSON: name, color, rings: how strongly they stand out, 0 to
// 1), which of them its stock is of, what the page is called in its requests over HTTP, and what it
// is: 0 carved, 1 only looked at, 2 an experiment. All that was shown before is of another one.
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
// Surface of one body that changed; the page answers Got. Each chunk: place x y z (u16), numbers of
// vertices and triangles (u32), whether any is painted (u16), vertices, corners (u16 each), and of
// painted ones a colour for each vertex (red, green, blue, 255 where it is painted or 0: u8). A
// vertex: x y z (u16, 1/2048 pitch from 16 place - 1), normal (3 x i8, 1/127), material (u8).
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
// Every servo tick since the last: tip [mm], force of the wood on the tool [N], moment about the
// tip [N mm], and of the tool's frame the third column (its axis) and the first, fifteen f32 a
// tick. start: number of the first.
struct Ticks {
  static constexpr uint8_t kKind = 66;
  double start = 0;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(start, data);
  }
};
// Volume [mm^3], how much less that is than the stock's [mm^3], where the document stands; whether
// this page holds the tool; whether the tool, which is pressed, stands in material and can't back
// out. Of a force device: safety 0 off, 1 waits for the hand to be still, 2 pushes; why it is off;
// the force it gives [N].
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
  std::string hash;
  uint8_t safety = 0;
  std::string trip;
  double given = 0;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(volume, removed, step, steps, undo, redo, holds, blocked, hash, safety, trip, given);
  }
};
// A sentence for the person.
struct Notice {
  static constexpr uint8_t kKind = 68;
  std::string text;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(text);
  }
};
// No document is open. JSON: documents (name, changed: s since 1970, bytes), materials (as of
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
// Steps that this page was not told of yet, by their numbers: number, the one before it or 0 (u32
// each), what it removed [mm^3] (f32), when it was begun [s since 1970] (f64; 0: not known), the
// tool (text, as JSON; null: none), mode (u8; off: the tool only moved), whether a thumbnail of it
// is kept (u8), label (text).
struct Steps {
  static constexpr uint8_t kKind = 70;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(data);
  }
};
// JSON: the number of the step of each name.
struct Versions {
  static constexpr uint8_t kKind = 71;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json);
  }
};
// What takes a while and can be cancelled; empty: nothing. share: how much of it is done, 0 to 1;
// below 0: not known.
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
// After Welcome, where a force device holds the tool, and whenever its reach or the hand changes:
// its name, the force it can give [N] (0: none), the stiffness that it renders and the greatest it
// can bear [N/mm, at the hand], the reach, and which share of the wood's force is felt.
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
// What an experiment came to. JSON: run (a number of its own), name, model, finished, ticks,
// removed_mm3, mean_force_N (where there is any), max_force_N, max_moment_Nmm, step_us, marks
// (label, time_s). Rows: time [s], force [N], moment [N mm], seven f32; of at most 100 000, those
// with the largest force.
struct Trace {
  static constexpr uint8_t kKind = 74;
  std::string json;
  std::vector<uint8_t> data;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json, data);
  }
};
// The tool from now on, of an experiment or of whoever holds it.
struct ShowTool {
  static constexpr uint8_t kKind = 75;
  std::string tool;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(tool);
  }
};
// Answers AskMethod from the newest snapshot. Rays u, u + every, ... (columns of them) by v, v +
// every, ... (rows of them) of the field, 32 both ways at most: where that would be more, every is
// larger than it was asked. spans: of each ray, u first, how many spans reach between the depths
// low and high [lattice units] (u8, the first 16), and of each its ends in and out (f32). vanished:
// nodes x y z (u16 each) between these depths, on these rays and on those between them, four times
// as many both ways or all, that were in the material when this page was answered last and are not
// now, evenly chosen where they are more than 2048; gone: how many they are. Of the newest tick
// that took or added any: points (K, of the whole model), volume (how much less material there is
// for it [mm^3]), motion (of the tool's tip [mm]), force (of the wood on the tool [N]). ticks: how
// many there were since the last answer, and taken: K of them all.
struct Method {
  static constexpr uint8_t kKind = 76;
  uint8_t axis = 0;
  uint16_t every = 0;
  uint16_t u = 0;
  uint16_t v = 0;
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
// Which bodies there are, and the one that strokes go to. JSON: id, name, pose (of the body's
// lattice in the world: its origin [mm], then the columns of its frame), visible, locked, no_go,
// volume_mm3. Chunks of a body that is not there, is hidden, or stands otherwise than it was told
// before are no more; those of one that is shown follow.
struct Bodies {
  static constexpr uint8_t kKind = 77;
  uint32_t active = 0;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(active, json);
  }
};
// Of what ShowRemains asked for: how far the surface of the body that is worked on is from what is
// no-go, at most and on average [mm], how much of it is outside that [mm^3], and the distance that
// has the last colour [mm]. A scale of 0: nothing is no-go, and no colours are shown.
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
// Answers PreviewAction: why it can't be shown, or empty. Of a spline, forces: JSON, of each
// control point the force [N] on the hand that moved it there since the last preview, as of soft
// clay.
struct Previewed {
  static constexpr uint8_t kKind = 79;
  std::string error;
  std::string forces;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(error, forces);
  }
};
// The second hand's tool as of the newest tick: tip [mm], the third column of its frame (its axis)
// and the first, and the force of the wood on it [N]; there: 0 where there is no second hand.
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
// Answers AskMass: the body, its volume [mm^3], its mass [g] (0: of one of its materials the
// density is not known), and its centre of gravity [mm] in the world.
struct Mass {
  static constexpr uint8_t kKind = 81;
  uint32_t body = 0;
  double volume = 0;
  double mass = 0;
  Vec3 centre = Vec3::Zero();
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(body, volume, mass, centre);
  }
};
// The stamp that is held: its triangles in its own frame [mm], tip at the origin: vertices (three
// f32 each) and their corners (three u32 each).
struct ShowStamp {
  static constexpr uint8_t kKind = 82;
  std::vector<uint8_t> vertices;
  std::vector<uint8_t> triangles;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(vertices, triangles);
  }
};
// Answers AskFonts. JSON: the families, in alphabetical order.
struct Fonts {
  static constexpr uint8_t kKind = 83;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(json);
  }
};
// Of what ShowFaults asked for: surface that hangs, and that is of thin walls [mm^2], of so much in
// all; the thinnest wall [mm], 0: there is none; and how many pieces there are, of which all but
// the largest are loose.
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
// At --publish HOST:PORT, the first message and again where another document is opened; readers say
// nothing. JSON: what the rows of PublishedTicks are of, row_bytes, and their columns (name, type,
// offset in bytes, count).
struct PublishedAbout {
  static constexpr uint8_t kKind = 96;
  uint16_t version = 0;
  std::string json;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(version, json);
  }
};
// Every servo tick since the last such message: rows of PublishedAbout's row_bytes, one for each hand.
struct PublishedTicks {
  static constexpr uint8_t kKind = 97;
  std::vector<uint8_t> rows;
  template <class F>
  void fields([[maybe_unused]] F&& f) {
    f(rows);
  }
};

// What a page may say.
using FromPage = std::variant<Hello, Aim, Press, Lift, Cancel, Undo, Redo, ChooseTool, ChooseHand, Got, TakeTool, Begin, Open, Leave, Go, NameVersion, KeepThumbnail, ChooseMaterial, ChooseModel, CancelWork, CarveExample, ChooseSymmetry, ChooseWork, Arm, BringTool, ChooseReach, RunExperiment, ChooseTurn, Strike, ChooseBrush, AskMethod, ActOnBodies, ChooseBody, ChooseCrumbs, ShowRemains, PreviewAction, ReviseStep, ChooseSecond, PressSecond, AimSecond, LiftSecond, ChooseGuide, AskMass, ChooseStamp, AskFonts, ShowFaults>;

}  // namespace kibori::studio
