// SPDX-License-Identifier: MIT
// Converts the path of the hand into the path of the tool, before a stroke follows it.
//
//   hand ──► string (steady) ──► guide (line, circle, curve) ──► lead or stamp ──► path
//
//   steady   A string draws the tool behind the hand. The tool rests while the string is slack.
//   guide    The tip moves to the nearest place on the line, circle or curve, seen along the tool's
//            axis. The height along the axis stays that of the hand.
//   lead     The tool's local x axis turns to the direction of the path, as a gouge needs. The tool
//            waits above the wood until the direction is known. It enters over `entry_mm`. It stays
//            `entry_mm` behind the hand, so that it can leave over the same length at the stroke's
//            end.
//   stamp    The tool is pressed in where the stroke begins, or at equal distances of the path. It
//            moves from place to place above the wood.
//
//            hand's path  ●────────────────────────●
//            tip           ╲______________________╱     entry_mm long on both sides
//
// The path depends only on the positions and times of the hand.
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
  // Line: its direction is a multiple of this angle [degrees]. The angle is measured about the
  // tool's axis, from the world's x axis. If the tool points along x, it is measured from y. 0: any
  // direction.
  double snap_deg = 0;
  // Circle: a point on its axis. The axis is parallel to the tool's axis at the stroke's beginning.
  Vec3 centre_mm = Vec3::Zero();
  // Curve: a polyline.
  std::vector<Vec3> curve_mm;
  bool closed = false;   // joins the last point to the first
  double steady_mm = 0;  // length of the string
  bool lead = false;
  double entry_mm = 0;  // lead: length of entry and exit
  double lift_mm = 0;   // entry and exit start this far above the path, along the tool's axis
  // The tool is pressed in and drawn out. If it also leads, it is turned to the direction of the
  // path. every_mm: distance between places along the path above the wood; 0: once, where the
  // stroke begins.
  bool stamp = false;
  double every_mm = 0;
  bool operator==(const StrokeGuideSettings&) const = default;

  // True if the tool's path can differ from the hand's.
  bool guides() const { return guide != Guide::none || steady_mm > 0 || lead || stamp; }
};

// Returns Ok, or one sentence that names the invalid setting.
Status check_stroke_guide(const StrokeGuideSettings& settings);

class StrokeGuide {
 public:
  // Receives a pose of the path and its time [s].
  using Emit = std::function<void(const Pose&, double)>;

  // Precondition: check_stroke_guide accepted the settings.
  explicit StrokeGuide(StrokeGuideSettings settings) : settings_(std::move(settings)) {}

  // Begins a stroke at the hand's pose and returns the path's first pose. move() and end() emit the
  // other poses in order.
  Pose begin(const Pose& hand, double time_s);
  void move(const Pose& hand, double time_s, const Emit& emit);
  void end(const Emit& emit);

 private:
  struct Place {
    Pose pose;
    double time_s;
    double distance_mm;  // distance from the beginning of the path
  };

  std::optional<Vec3> guided(const Pose& hand);
  std::vector<Vec3> between(const Vec3& from, double from_mm, const Vec3& to) const;
  Vec3 on_curve(const Vec3& tip);
  Vec3 direction_at(const Vec3& tip, const Vec3& head) const;
  void follow(const Pose& pose, double time_s, const Emit& emit);
  void lead_to(const Pose& pose, double time_s, const Emit& emit);
  void stamp_to(const Pose& pose, double time_s, const Emit& emit);
  void press(const Pose& pose, double time_s, const Emit& emit);
  void give(const Place& place, double left_mm, const Emit& emit) const;

  StrokeGuideSettings settings_;
  Vec3 start_ = Vec3::Zero(),
       normal_ = Vec3::UnitZ();    // of the stroke: the hand's first position and axis
  std::optional<Vec3> direction_;  // line: its direction, once known
  double along_mm_ = -1;           // curve: position of the tool along it
  Vec3 drawn_ = Vec3::Zero();      // end of the string at the tool
  Vec3 at_ = Vec3::Zero();         // last guided position of the tip
  Pose guided_{};                  // last guided pose, and its time
  double guided_s_ = 0;
  // State of a tool that leads.
  Vec3 trail_ = Vec3::Zero();  // point that trails behind the tool; gives the direction
  bool turned_ = false;        // the direction is known
  std::deque<Place> behind_;   // places that may belong to the exit, so they are not emitted yet
  // State of a stamp.
  Place over_{};               // current place above the wood
  Vec3 begun_ = Vec3::Zero();  // where the stroke began
  double next_mm_ = 0;         // position of the next press along the path
  double pressing_s_ = 0;      // total time of the presses so far
};

}  // namespace kibori
