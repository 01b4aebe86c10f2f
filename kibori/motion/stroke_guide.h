// SPDX-License-Identifier: MIT
// Converts the path of the hand into the path that the tool of a stroke follows.
//
//   hand ──► string (steady) ──► guide (line, circle, curve) ──► lead or stamp ──► path
//
//   steady   A string draws the tool behind the hand. While the string is slack, the tool rests.
//   guide    The tip moves to the nearest place on the line, circle or curve, seen along the tool's
//            axis. Along this axis, the tip keeps the height of the hand.
//   lead     The tool's local x axis turns to the direction of the path, as a gouge needs. The tool
//            waits above the wood until the direction is known. It enters the wood over `entry_mm`.
//            It stays `entry_mm` behind the hand. So it can leave the wood over the same length at
//            the end of the stroke.
//   stamp    The tool is pressed in at the stroke's beginning, or at equal distances of the path.
//            Between these places, it moves above the wood.
//
//            hand's path  ●────────────────────────●
//            tip           ╲______________________╱     entry_mm long on both sides
//
// The result depends only on the poses and the times of the hand.
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
  // Line: if above 0, the direction of the line is a multiple of this angle [degrees]. The angle is
  // measured about the tool's axis, from the world's x axis (from y if the tool points along x).
  double snap_deg = 0;
  // Circle: a point on its axis. This axis is parallel to the tool's axis at the stroke's
  // beginning.
  Vec3 centre_mm = Vec3::Zero();
  // Curve: the points of a polyline.
  std::vector<Vec3> curve_mm;
  bool closed = false;   // curve: a segment joins the last point to the first
  double steady_mm = 0;  // length of the string; 0: no string
  bool lead = false;
  double entry_mm = 0;  // lead: length of the entry and of the exit
  double lift_mm = 0;   // entry starts and exit ends at this height above the path
  // Stamp: the tool is pressed in and drawn out. If `lead` is also set, it turns to the direction
  // of the path. every_mm: distance between the places along the path; 0: only one place, where the
  // stroke begins.
  bool stamp = false;
  double every_mm = 0;
  bool operator==(const StrokeGuideSettings&) const = default;

  // Returns true if the path of the tool can differ from the path of the hand.
  bool guides() const { return guide != Guide::none || steady_mm > 0 || lead || stamp; }
};

// Returns Ok if the settings are valid. Otherwise, returns an error sentence that names the
// setting.
Status check_stroke_guide(const StrokeGuideSettings& settings);

class StrokeGuide {
 public:
  // Receives a pose of the tool's path and its time [s].
  using Emit = std::function<void(const Pose&, double)>;

  // Precondition: check_stroke_guide accepted the settings.
  explicit StrokeGuide(StrokeGuideSettings settings) : settings_(std::move(settings)) {}

  // begin() starts a stroke at the hand's pose, and returns the first pose of the tool's path.
  // move() and end() pass the next poses to `emit`, in order.
  Pose begin(const Pose& hand, double time_s);
  void move(const Pose& hand, double time_s, const Emit& emit);
  void end(const Emit& emit);

 private:
  struct Place {
    Pose pose;
    double time_s;
    double distance_mm;  // along the path, from its beginning
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
       normal_ = Vec3::UnitZ();    // the hand's first position, and the tool's first axis
  std::optional<Vec3> direction_;  // line: its direction, as soon as it is known
  double along_mm_ = -1;           // curve: position of the tool along it; negative: unknown
  Vec3 drawn_ = Vec3::Zero();      // where the string holds the tool
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
