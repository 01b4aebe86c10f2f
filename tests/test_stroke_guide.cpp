// SPDX-License-Identifier: MIT
// Guided strokes against closed forms. One of them carves: its channel has the gouge's section.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/motion/direct_tool.h>
#include <kibori/motion/stroke_guide.h>
#include <kibori/solid/tool.h>

#include "tests/support.h"

namespace kibori::stroke_guide_tests {
namespace {

using test::Random;

struct Timed {
  Pose pose;
  double time_s;
};

// The path of a stroke whose hand is at these places.
std::vector<Timed> path_of(const StrokeGuideSettings& settings, const std::vector<Timed>& hand) {
  EXPECT_TRUE(check_stroke_guide(settings)) << check_stroke_guide(settings).error();
  StrokeGuide guide(settings);
  std::vector<Timed> path{
      {guide.begin(hand.front().pose, hand.front().time_s), hand.front().time_s}};
  const auto take = [&](const Pose& pose, double time_s) { path.push_back({pose, time_s}); };
  for (size_t i = 1; i < hand.size(); i++) guide.move(hand[i].pose, hand[i].time_s, take);
  guide.end(take);
  return path;
}

Timed at(const Vec3& tip, double time_s, const Vec3& axis = Vec3::UnitZ()) {
  return {{tip, frame_from_axis(axis)}, time_s};
}

// A random path of a hand.
std::vector<Timed> wandering(Random& random, int count, double step_mm) {
  std::vector<Timed> hand;
  Vec3 tip = random.in_box(10, 60), direction = random.direction();
  const Vec3 axis = random.direction();
  for (int i = 0; i < count; i++) {
    hand.push_back(at(tip, 0.01 * i, axis));
    direction = (direction + 0.4 * random.direction()).normalized();
    tip += random.uniform(0, step_mm) * direction;
  }
  return hand;
}

Vec3 across(const Vec3& v, const Vec3& unit) { return v - v.dot(unit) * unit; }

// The poses of a path at the times of the hand. Those between them are left out.
std::vector<Timed> at_times_of(const std::vector<Timed>& hand, const std::vector<Timed>& path) {
  std::vector<Timed> poses;
  size_t next = 0;
  for (const Timed& place : path)
    if (next < hand.size() && place.time_s == hand[next].time_s) {
      poses.push_back(place);
      next++;
    }
  return poses;
}

TEST(StrokeGuide, WithoutAnyTheHandIsFollowed) {
  Random random;
  const std::vector<Timed> hand = wandering(random, 50, 2), path = path_of({}, hand);
  ASSERT_EQ(path.size(), hand.size());
  for (size_t i = 0; i < hand.size(); i++) {
    EXPECT_EQ(path[i].pose.tip, hand[i].pose.tip);
    EXPECT_EQ(path[i].time_s, hand[i].time_s);
  }
}

TEST(StrokeGuide, ALineHasADirectionThatIsSnapped) {
  Random random;
  for (int trial = 0; trial < 200; trial++) {
    StrokeGuideSettings settings;
    settings.guide = Guide::line;
    settings.snap_deg = trial % 4 == 0 ? 0 : trial % 4 == 1 ? 15 : trial % 4 == 2 ? 45 : 90;
    const std::vector<Timed> hand = wandering(random, 60, 2), path = path_of(settings, hand);
    const Pose& first = hand.front().pose;
    ASSERT_EQ(path.front().pose.tip, first.tip);
    if (path.size() < 2) continue;
    // Seen along the axis, the whole path is on one line through its first point.
    Vec3 direction = Vec3::Zero();
    for (const Timed& place : path) {
      const Vec3 off = across(place.pose.tip - first.tip, first.axis());
      if (off.norm() > direction.norm()) direction = off;
    }
    direction.normalize();
    for (size_t i = 0; i < path.size(); i++)
      ASSERT_LT(across(across(path[i].pose.tip - first.tip, first.axis()), direction).norm(), 1e-9)
          << random.note();
    if (settings.snap_deg > 0) {
      const double turn =
          std::atan2(direction.dot(first.frame.col(1)), direction.dot(first.frame.col(0))) * 180 /
          std::numbers::pi / settings.snap_deg;
      EXPECT_NEAR(turn, std::round(turn), 1e-9) << random.note();
    }
    // The tool has the hand's height, and the hand's distance along the line.
    const size_t skipped = hand.size() - path.size();
    for (size_t i = 1; i < path.size(); i++) {
      const Vec3 apart = path[i].pose.tip - hand[i + skipped].pose.tip;
      EXPECT_NEAR(apart.dot(first.axis()), 0, 1e-9) << random.note();
      EXPECT_NEAR(apart.dot(direction), 0, 1e-9) << random.note();
    }
  }
}

TEST(StrokeGuide, ACircleKeepsItsRadius) {
  Random random;
  for (int trial = 0; trial < 200; trial++) {
    StrokeGuideSettings settings;
    settings.guide = Guide::circle;
    settings.centre_mm = random.in_box(0, 60);
    const std::vector<Timed> hand = wandering(random, 60, 3), whole = path_of(settings, hand),
                             path = at_times_of(hand, whole);
    const Vec3 axis = hand.front().pose.axis();
    const auto flat = [&](const Vec3& tip) { return across(tip - settings.centre_mm, axis); };
    ASSERT_EQ(path.size(), hand.size());
    const double radius = flat(hand.front().pose.tip).norm();
    for (size_t i = 0; i < path.size(); i++) {
      EXPECT_NEAR(flat(path[i].pose.tip).norm(), radius, 1e-9) << random.note();
      EXPECT_NEAR(flat(path[i].pose.tip).normalized().dot(flat(hand[i].pose.tip).normalized()), 1,
                  1e-9);
      EXPECT_NEAR((path[i].pose.tip - hand[i].pose.tip).dot(axis), 0, 1e-9);
    }
    // The middles of the path's pieces are on the circle too.
    for (size_t i = 1; i < whole.size(); i++) {
      const Vec3 middle = 0.5 * (whole[i - 1].pose.tip + whole[i].pose.tip);
      EXPECT_NEAR(flat(middle).norm(), radius, 0.0101) << random.note();
      EXPECT_GE(whole[i].time_s, whole[i - 1].time_s);
    }
  }
}

// A hand that reports few positions still leaves the corners of the curve sharp: in both
// directions, and where a closed curve begins.
TEST(StrokeGuide, ACurveKeepsItsCorners) {
  StrokeGuideSettings settings;
  settings.guide = Guide::curve;
  settings.closed = true;
  settings.curve_mm = {{0, 0, 2}, {20, 0, 2}, {20, 10, 2}, {0, 10, 2}};
  const auto on_rectangle = [](double s) {
    s = std::fmod(s + 600, 60);
    return s < 20   ? Vec3(s, 0, 2)
           : s < 30 ? Vec3(20, s - 20, 2)
           : s < 50 ? Vec3(50 - s, 10, 2)
                    : Vec3(0, 60 - s, 2);
  };
  for (const double way : {3.7, -3.7}) {
    std::vector<Timed> hand;
    for (int i = 0; i <= 40; i++) hand.push_back(at(on_rectangle(5 + way * i), 0.01 * i));
    const std::vector<Timed> path = path_of(settings, hand);
    double drawn = 0;
    std::array<int, 4> corners{};
    for (size_t i = 1; i < path.size(); i++) {
      drawn += (path[i].pose.tip - path[i - 1].pose.tip).norm();
      for (size_t k = 0; k < 4; k++)
        corners[k] += (path[i].pose.tip - settings.curve_mm[k]).norm() < 1e-9;
    }
    EXPECT_NEAR(drawn, 40 * 3.7, 1e-6);  // chords would be shorter
    for (const int times : corners) EXPECT_GE(times, 2);
  }
}

TEST(StrokeGuide, ACurveIsFollowedWhereItIsNearest) {
  // The curve is a wave. The oracle searches the whole curve in small steps.
  std::vector<Vec3> curve;
  for (int i = 0; i <= 200; i++) curve.push_back(Vec3(0.3 * i, 5 * std::sin(0.03 * i * 3), 2));
  StrokeGuideSettings settings;
  settings.guide = Guide::curve;
  settings.curve_mm = curve;
  Random random;
  for (int trial = 0; trial < 50; trial++) {
    std::vector<Timed> hand;
    const double aside = random.uniform(-1, 1);
    for (int i = 0; i <= 100; i++)
      hand.push_back(
          at(Vec3(0.6 * i, 5 * std::sin(0.06 * i * 3) + aside, random.uniform(0, 3)), 0.01 * i));
    const std::vector<Timed> path = at_times_of(hand, path_of(settings, hand));
    ASSERT_EQ(path.size(), hand.size());
    for (size_t i = 0; i < path.size(); i++) {
      double nearest = 1e30;
      for (size_t k = 0; k + 1 < curve.size(); k++)
        for (int j = 0; j < 40; j++) {
          const Vec3 on = curve[k] + (j / 40.0) * (curve[k + 1] - curve[k]);
          nearest = std::min(
              nearest, std::hypot(on.x() - hand[i].pose.tip.x(), on.y() - hand[i].pose.tip.y()));
        }
      const Vec3 off = path[i].pose.tip - hand[i].pose.tip;
      EXPECT_NEAR(std::hypot(off.x(), off.y()), nearest, 0.02) << i << "; " << random.note();
      EXPECT_NEAR(path[i].pose.tip.z(), hand[i].pose.tip.z(), 1e-9);
    }
  }
}

// Where a curve crosses itself, or comes near itself, the tool stays on its own branch.
TEST(StrokeGuide, ACurveIsNotLeapedAcross) {
  StrokeGuideSettings settings;
  settings.guide = Guide::curve;
  const auto hairpin = [](double s) {  // there and back, 2 mm apart
    return s < 40 ? Vec3(s, 0, 0) : s < 42 ? Vec3(40, s - 40, 0) : Vec3(82 - s, 2, 0);
  };
  for (int i = 0; i <= 82; i++) settings.curve_mm.push_back(hairpin(i));
  std::vector<Timed> hand;
  // The hand is nearer to the other branch half of the time.
  for (int i = 0; i < 36; i++) hand.push_back(at(Vec3(i, i % 2 ? 1.3 : 0.2, 0), 0.01 * i));
  for (const Timed& place : path_of(settings, hand)) EXPECT_NEAR(place.pose.tip.y(), 0, 1e-9);
}

TEST(StrokeGuide, ASteadyToolIsDrawnOnAString) {
  Random random;
  for (int trial = 0; trial < 100; trial++) {
    StrokeGuideSettings settings;
    settings.steady_mm = random.uniform(0.5, 8);
    const std::vector<Timed> hand = wandering(random, 60, 2);
    StrokeGuide guide(settings);
    Vec3 tip = guide.begin(hand.front().pose, 0).tip;
    for (size_t i = 1; i < hand.size(); i++) {
      const Vec3 before = tip, to_hand = hand[i].pose.tip - tip;
      int count = 0;
      guide.move(hand[i].pose, hand[i].time_s,
                 [&](const Pose& pose, double) { tip = pose.tip, count++; });
      ASSERT_EQ(count, to_hand.norm() > settings.steady_mm ? 1 : 0) << random.note();
      // Straight towards the hand, and no farther than the string requires.
      EXPECT_LT((tip - before).cross(to_hand).norm(), 1e-9 * (1 + to_hand.norm()));
      EXPECT_LE((hand[i].pose.tip - tip).norm(), settings.steady_mm + 1e-9);
    }
  }
}

TEST(StrokeGuide, ALeadingToolTurnsEntersAndLeaves) {
  StrokeGuideSettings settings;
  settings.lead = true;
  settings.entry_mm = 5;
  settings.lift_mm = 2.5;
  for (const double length : {30.0, 7.0, 3.0})
    for (const double apart : {0.1, 1.7, 11.0}) {
      std::vector<Timed> hand;
      const Vec3 direction = Vec3(0.6, 0.8, 0);
      const int count = static_cast<int>(std::ceil(length / apart));
      for (int i = 0; i <= count; i++)
        hand.push_back(at(Vec3(3, 4, 1) + length * i / count * direction, 0.02 * i));
      const std::vector<Timed> path = path_of(settings, hand);
      double last_s = -1, deepest = 1e30;
      for (const Timed& place : path) {
        EXPECT_GE(place.time_s, last_s);
        last_s = place.time_s;
        const Vec3 off = place.pose.tip - Vec3(3, 4, 1);
        const double along = off.dot(direction),
                     share = 1 - std::min({along / 5, (length - along) / 5, 1.0});
        EXPECT_NEAR(off.z(), 2.5 * share * share, 1e-9) << length << " " << apart << " " << along;
        EXPECT_LT(across(Vec3(off.x(), off.y(), 0), direction).norm(), 1e-9);
        deepest = std::min(deepest, off.z());
      }
      for (size_t i = 1; i < path.size(); i++)
        EXPECT_LT((path[i].pose.frame.col(0) - direction).norm(), 1e-9)
            << length << " " << apart << " " << i;
      EXPECT_NEAR(path.back().pose.tip.z(), 1 + 2.5, 1e-9);
      EXPECT_NEAR((path.back().pose.tip - hand.back().pose.tip).head<2>().norm(), 0, 1e-9);
      if (length >= 10) {
        EXPECT_NEAR(deepest, 0, 1e-9);
      }
    }
}

TEST(StrokeGuide, APressWithoutMotionEntersAndLeaves) {
  StrokeGuideSettings settings;
  settings.lead = true;
  settings.entry_mm = 5;
  settings.lift_mm = 2.5;
  const std::vector<Timed> path =
      path_of(settings, {at(Vec3(1, 2, 3), 0), at(Vec3(1.2, 2, 3), 0.1)});
  ASSERT_EQ(path.size(), 3u);
  EXPECT_EQ(path[0].pose.tip.z(), 5.5);
  EXPECT_EQ(path[1].pose.tip.z(), 3);
  EXPECT_EQ(path[2].pose.tip.z(), 5.5);
  EXPECT_GT(path[1].time_s, path[0].time_s);
  EXPECT_GT(path[2].time_s, path[1].time_s);
}

// Any settings and any motion of the hand: positions are finite, frames are rotations, times
// increase.
TEST(StrokeGuide, AnyStrokeIsAPath) {
  Random random;
  for (int trial = 0; trial < test::rounds_of("KIBORI_GUIDES", 2000); trial++) {
    StrokeGuideSettings settings;
    settings.guide = static_cast<Guide>(random.integer(0, 3));
    settings.snap_deg = random.integer(0, 1) ? 0 : random.uniform(1, 180);
    settings.centre_mm = random.in_box(0, 60);
    for (int i = 0; i < random.integer(2, 20); i++)
      settings.curve_mm.push_back(random.integer(0, 5) && i > 0 ? Vec3(random.in_box(0, 60))
                                  : i > 0                       ? settings.curve_mm.back()
                                                                : Vec3(random.in_box(0, 60)));
    settings.closed = random.integer(0, 1);
    settings.steady_mm = random.integer(0, 1) ? 0 : random.uniform(0, 10);
    settings.lead = random.integer(0, 1);
    settings.entry_mm = random.integer(0, 2) ? random.uniform(0, 10) : 0;
    settings.lift_mm = random.integer(0, 2) ? random.uniform(0, 10) : 0;
    if (settings.guide == Guide::curve && settings.curve_mm.size() < 2) continue;
    std::vector<Timed> hand =
        wandering(random, random.integer(1, 40), random.integer(0, 3) ? 3.0 : 0.0);
    if (random.integer(0, 3) == 0)
      for (Timed& place : hand) place.pose.frame = frame_from_axis(random.direction());
    double last_s = -1;
    for (const Timed& place : path_of(settings, hand)) {
      ASSERT_TRUE(place.pose.tip.allFinite()) << random.note();
      ASSERT_LT((place.pose.frame.transpose() * place.pose.frame - Mat3::Identity()).norm(), 1e-9)
          << random.note();
      ASSERT_GT(place.pose.frame.determinant(), 0);
      ASSERT_GE(place.time_s, last_s) << random.note();
      last_s = place.time_s;
    }
  }
}

TEST(StrokeGuide, InvalidInputIsReportedInASentence) {
  StrokeGuideSettings settings;
  settings.guide = Guide::curve;
  EXPECT_FALSE(check_stroke_guide(settings));
  settings.curve_mm = {Vec3::Zero(), Vec3(std::nan(""), 0, 0)};
  EXPECT_FALSE(check_stroke_guide(settings));
  settings = {};
  settings.steady_mm = -1;
  EXPECT_FALSE(check_stroke_guide(settings));
  settings = {};
  settings.snap_deg = 400;
  EXPECT_FALSE(check_stroke_guide(settings));
}

// A gouge that leads around a bend leaves a channel with its own section, as long as the hand's
// path. The channel ends at the surface on both sides.
TEST(StrokeGuide, AGougeLeavesACleanChannel) {
  Random random;
  for (const double sweep : {3.0, 7.0, 9.0, 11.0}) {
    const Gouge gouge{sweep, 8, 1, 20};
    TriDexel model(make_lattice(Vec3(60, 40, 12), 0.25, 2).value());
    model.fill_block({Vec3::Zero(), Vec3(60, 40, 12)}, 0);
    StrokeGuideSettings settings;
    settings.lead = true;
    settings.entry_mm = 5;
    const double depth = std::min(2.0, gouge_arc(gouge).depth);
    settings.lift_mm = depth + 0.5;
    std::vector<Timed> hand;
    for (int i = 0; i <= 200; i++) {
      const double x = 8 + 44.0 * i / 200;
      hand.push_back(at(Vec3(x, 20, 12 - depth), 0.01 * i));
    }
    const std::vector<Timed> path = path_of(settings, hand);
    DirectTool tool(model, path.front().pose);
    for (size_t i = 1; i < path.size(); i++) {
      const auto tick = tool.advance(gouge, path[i].pose.tip,
                                     rotation_between(path[i - 1].pose.frame, path[i].pose.frame),
                                     Mode::cut, {}, {Material{}});
      ASSERT_TRUE(tick.ok()) << tick.error();
    }
    // Across the middle: the top of the material at each y is the section's, within a twentieth of
    // a cell.
    const Lattice& lattice = model.lattice();
    const FieldSnapshot field = model.snapshot().field(Axis::z);
    const auto top = [&](double x, double y) {
      const Vec3 units = lattice.to_lattice(Vec3(x, y, 0)).units;
      const int u = static_cast<int>(std::floor(units[u_index(Axis::z)])),
                v = static_cast<int>(std::floor(units[v_index(Axis::z)]));
      double high = 0;
      field.for_spans(u, v, [&](const Span& s) { high = std::max<double>(high, s.out); });
      Vec3 ray = Vec3::Zero();
      ray[u_index(Axis::z)] = u + 0.5;
      ray[v_index(Axis::z)] = v + 0.5;
      ray[depth_index(Axis::z)] = high;
      return lattice.to_mm(LatticePoint{ray});
    };
    const GougeArc arc = gouge_arc(gouge);
    for (double y = 14; y < 26; y += 0.25) {
      const Vec3 p = top(30, y);
      const double off = std::abs(p.y() - 20);
      // The section's height over its lowest line; upright walls beyond the arc.
      const double over =
          off > 4 ? 1e9
                  : arc.upright *
                        (1 - std::sqrt(std::max(0.0, 1 - off * off / (arc.across * arc.across))));
      EXPECT_NEAR(p.z(), std::min(12.0, 12 - depth + over), 0.05 * 0.25) << sweep << " at " << y;
    }
    // At both ends of the hand's path the wood is untouched.
    EXPECT_NEAR(top(7, 20).z(), 12, 1e-5);
    EXPECT_NEAR(top(53, 20).z(), 12, 1e-5);
    EXPECT_LT(top(14, 20).z(), 12 - 0.99 * depth);
    EXPECT_LT(top(46, 20).z(), 12 - 0.99 * depth);
  }
}

// ---- Stamps

// Places where a stamp is pressed in: they are as deep as the hand, with places above them before
// and after.
std::vector<Pose> pressed(const std::vector<Timed>& path, double lift_mm) {
  std::vector<Pose> places;
  for (size_t i = 1; i + 1 < path.size(); i++) {
    const auto above = [&](const Timed& t) {
      return (t.pose.tip - path[i].pose.tip - lift_mm * path[i].pose.axis()).norm() < 1e-9;
    };
    if (above(path[i - 1]) && above(path[i + 1])) places.push_back(path[i].pose);
  }
  return places;
}

TEST(StrokeGuide, AStampIsPressedInOnceWhereTheStrokeBegins) {
  Random random;
  StrokeGuideSettings settings;
  settings.stamp = true;
  settings.lift_mm = 3;
  for (int round = 0; round < 50; round++) {
    settings.lead = round % 2 == 1;
    const std::vector<Timed> hand = wandering(random, random.integer(1, 40), 2),
                             path = path_of(settings, hand);
    ASSERT_EQ(path.size(), 4u) << random.note();
    const std::vector<Pose> places = pressed(path, 3);
    ASSERT_EQ(places.size(), 1u) << random.note();
    EXPECT_EQ(places[0].tip, hand[0].pose.tip);
    const Vec3 direction = across(hand.back().pose.tip - hand[0].pose.tip, hand[0].pose.axis());
    if (!settings.lead) {
      EXPECT_EQ(places[0].frame, hand[0].pose.frame);
    } else if (direction.norm() > 2) {
      EXPECT_GT(places[0].frame.col(0).dot(direction.normalized()), 1 - 1e-9) << random.note();
    }
    for (size_t i = 1; i < path.size(); i++) EXPECT_GE(path[i].time_s, path[i - 1].time_s);
  }
}

TEST(StrokeGuide, AStampIsPressedInAtEqualDistances) {
  Random random;
  for (int round = 0; round < 100; round++) {
    StrokeGuideSettings settings;
    settings.stamp = true;
    settings.lead = round % 2 == 1;
    settings.lift_mm = random.uniform(0.5, 4);
    settings.every_mm = random.uniform(0.4, 9);
    // The hand moves straight ahead, by steps of any size.
    const Vec3 axis = random.direction(), direction = across(random.direction(), axis).normalized();
    std::vector<Timed> hand{at(random.in_box(0, 50), 0, axis)};
    double length = 0;
    for (int i = 1; i < 30; i++) {
      const double step = random.uniform(0, 4);
      length += step;
      hand.push_back(at(hand[0].pose.tip + length * direction, 0.02 * i, axis));
    }
    const std::vector<Timed> path = path_of(settings, hand);
    const std::vector<Pose> places = pressed(path, settings.lift_mm);
    ASSERT_EQ(places.size(), static_cast<size_t>(length / settings.every_mm) + 1) << random.note();
    for (size_t i = 0; i < places.size(); i++) {
      const Vec3 wanted = hand[0].pose.tip + static_cast<double>(i) * settings.every_mm * direction;
      EXPECT_LT((places[i].tip - wanted).norm(), 1e-6) << random.note();
      if (settings.lead) {
        EXPECT_GT(places[i].frame.col(0).dot(direction), 1 - 1e-9) << random.note();
      }
    }
    // Between two presses the stamp is never as deep as the hand.
    size_t deep = 0;
    for (const Timed& t : path)
      deep += (t.pose.tip - hand[0].pose.tip).dot(axis) < settings.lift_mm - 1e-9 ? 1 : 0;
    EXPECT_EQ(deep, places.size()) << random.note();
    for (size_t i = 1; i < path.size(); i++) EXPECT_GE(path[i].time_s, path[i - 1].time_s);
  }
}

TEST(StrokeGuide, AStampFollowsACircle) {
  StrokeGuideSettings settings;
  settings.guide = Guide::circle;
  settings.centre_mm = Vec3(20, 20, 0);
  settings.stamp = settings.lead = true;
  settings.lift_mm = 2;
  constexpr double kRadius = 12;
  settings.every_mm = 2 * std::numbers::pi * kRadius / 16;
  std::vector<Timed> hand;
  for (int i = 0; i <= 360; i++) {
    const double a = i * 0.99 * std::numbers::pi / 180;
    hand.push_back(at(settings.centre_mm + kRadius * Vec3(std::cos(a), std::sin(a), 0), 0.01 * i));
  }
  const std::vector<Pose> places = pressed(path_of(settings, hand), 2);
  ASSERT_EQ(places.size(), 16u);
  for (size_t i = 0; i < places.size(); i++) {
    const double a = 2 * std::numbers::pi * static_cast<double>(i) / 16;
    const Vec3 wanted = settings.centre_mm + kRadius * Vec3(std::cos(a), std::sin(a), 0);
    EXPECT_LT((places[i].tip - wanted).norm(), 0.05);
    EXPECT_GT(places[i].frame.col(0).dot(Vec3(-std::sin(a), std::cos(a), 0)), std::cos(0.005));
  }
}

TEST(StrokeGuide, AStampsDistanceIsChecked) {
  StrokeGuideSettings settings;
  settings.stamp = true;
  settings.every_mm = 0.01;
  EXPECT_FALSE(check_stroke_guide(settings));
  settings.every_mm = std::nan("");
  EXPECT_FALSE(check_stroke_guide(settings));
  settings.every_mm = 0.1;
  EXPECT_TRUE(check_stroke_guide(settings));
}

}  // namespace
}  // namespace kibori::stroke_guide_tests
