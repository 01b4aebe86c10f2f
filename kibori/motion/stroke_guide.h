// SPDX-License-Identifier: MIT
// A stroke that behaves: where a hand was, made into where its tool goes, before anything follows
// it.
//
//   hand ──► string (steady) ──► guide (line, circle, curve) ──► lead (turn, go in, come out) ──►
//   path
//
//   steady   the tool is drawn behind the hand on a string: it rests while the string is slack
//   guide    the place on the line, circle or curve that is nearest, seen along the tool's axis;
//   the
//            height along the axis stays the hand's
//   lead     the tool's local x axis turns to the way it goes, as a gouge's must. It waits above
//            the wood until it knows that way, goes in over `entry_mm`, and, drawn behind the hand
//            by as much, comes out over the same length where the stroke ends
//
//   stamp    the tool is pressed in where the stroke begins, or at equal distances along its way,
//            and carried from place to place above the wood
//
//            hand's path  ●────────────────────────●
//            tip           ╲______________________╱     entry_mm long on both sides
//
// The path is a function of the hand's places and times alone.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>

namespace kibori {

enum class Guide : uint8_t { none, line, circle, curve };
constexpr auto names_of(Guide) {
  return std::to_array<std::string_view>({"none", "line", "circle", "curve"});
}

struct StrokeGuideSettings {
  Guide guide = Guide::none;
  // Of a line: its direction is a multiple of this [degrees], counted about the tool's axis from
  // the x axis of the world (from y where the tool points along x); 0: any.
  double snap_deg = 0;
  // Of a circle: on its axis, which is that of the tool where the stroke begins.
  Vec3 centre_mm = Vec3::Zero();
  // Of a curve: a polyline.
  std::vector<Vec3> curve_mm;
  bool closed = false;   // its last point is joined to the first
  double steady_mm = 0;  // length of the string
  bool lead = false;
  double entry_mm = 0;  // of a tool that leads
  double lift_mm = 0;   // how far above its path, along its axis, it goes in and comes out
  // Pressed in and drawn out; a tool that leads is turned to its way meanwhile. every_mm: how far
  // from one place to the next, as the tool goes above the wood; 0: once, where the stroke begins.
  bool stamp = false;
  double every_mm = 0;
  bool operator==(const StrokeGuideSettings&) const = default;

  // Whether hand and tool go different ways at all.
  bool guides() const { return guide != Guide::none || steady_mm > 0 || lead || stamp; }
};

// Ok, or one sentence on what can't be.
Status check_stroke_guide(const StrokeGuideSettings& settings);

class StrokeGuide {
 public:
  // Takes a place of the path and its time [s].
  using Emit = std::function<void(const Pose&, double)>;

  // Settings that check_stroke_guide accepts.
  explicit StrokeGuide(StrokeGuideSettings settings) : settings_(std::move(settings)) {}

  // A stroke begins where the hand is. Gives the path's first place; the others come from move()
  // and end(), in order.
  Pose begin(const Pose& hand, double time_s);
  void move(const Pose& hand, double time_s, const Emit& emit);
  void end(const Emit& emit);

 private:
  struct Place {
    Pose pose;
    double time_s;
    double way_mm;  // along the path from its beginning
  };

  std::optional<Vec3> guided(const Pose& hand);
  Vec3 on_curve(const Vec3& tip);
  Vec3 way_at(const Vec3& tip, const Vec3& head) const;
  void lead_to(const Pose& pose, double time_s, const Emit& emit);
  void stamp_to(const Pose& pose, double time_s, const Emit& emit);
  void press(const Pose& pose, double time_s, const Emit& emit);
  void give(const Place& place, double left_mm, const Emit& emit) const;

  StrokeGuideSettings settings_;
  Vec3 start_ = Vec3::Zero(),
       normal_ = Vec3::UnitZ();    // of the stroke: first place of the hand, axis
  std::optional<Vec3> direction_;  // of a line, once it is known
  double along_mm_ = -1;           // of a curve: where on it the tool is
  Vec3 drawn_ = Vec3::Zero();      // the end of the string that is not the hand's
  Vec3 at_ = Vec3::Zero();         // where the guide had the tip last
  // Of a tool that leads.
  Vec3 trail_ = Vec3::Zero();  // drawn behind the tool: the way it goes is from there
  bool turned_ = false;        // the way is known
  std::deque<Place> behind_;   // of which it is not known yet how far they are from the end
  // Of a stamp.
  Place over_{};               // where it is carried
  Vec3 begun_ = Vec3::Zero();  // where the stroke began
  double next_mm_ = 0;         // along its way: where it is pressed in next
  double pressing_s_ = 0;      // how long it has been pressed in and drawn out by now
};

}  // namespace kibori
