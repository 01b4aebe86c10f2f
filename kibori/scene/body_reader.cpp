// SPDX-License-Identifier: MIT
// Reads the keys of a scene that concern bodies: crumbs, [[cutter]], [[spline]] and [[no_go]].
#include <kibori/scene/scene_reader.h>

namespace kibori {
namespace {

void read_no_go(SceneReader& reader, const TableReader& t) {
  t.only({"tool", "place", "axis", "roll_deg", "way", "name"});
  SceneNoGo made;
  made.line = t.line();
  made.tool = read_shape(reader, t);
  if (t.failed()) return;
  if (t.has("way")) {
    for (const char* key : {"place", "axis", "roll_deg"})
      if (t.has(key)) t.fail(key, t.full(key) + " and way exclude each other; give only one");
    made.path_mm = t.places("way");
  } else {
    made.pose.tip = t.vector("place");
  }
  made.pose.frame = read_frame(t);
  if (t.failed()) return;
  if (t.has("name")) made.name = t.text("name");
  if (made.name.size() > 100)
    t.fail("name", "[no_go] name may have at most 100 bytes; use a shorter one");
  for (const Move& move : reader.scene.moves)
    if (const Status fine = check_modes(move.mode, std::nullopt, true); !fine)
      return t.fail(move.line, "[move] " + fine.error());
  reader.scene.no_go.push_back(std::move(made));
}

void read_spline_shape(const TableReader& t, SplineShape& shape) {
  t.choice("kind", shape.kind);
  shape.curve.points_mm = t.places("points");
  shape.curve.closed = t.flag_or("closed", false);
  shape.curve.interpolate = t.flag_or("through", true);
  const auto only_of = [&](SplineKind kind, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
      if (shape.kind != kind && t.has(key))
        t.fail(key, t.full(key) + " needs kind = \"" + std::string(name_of(kind)) + "\"");
  };
  only_of(SplineKind::extrude, {"direction", "length"});
  only_of(SplineKind::revolve, {"axis_point", "axis"});
  only_of(SplineKind::sweep, {"radius"});
  if (t.failed()) return;
  if (t.has("direction")) shape.direction = t.vector("direction");
  if (shape.kind == SplineKind::extrude) shape.length_mm = t.positive("length");
  if (t.has("axis_point")) shape.axis_point_mm = t.vector("axis_point");
  if (t.has("axis")) shape.axis = t.vector("axis");
  if (shape.kind == SplineKind::sweep) shape.radius_mm = t.positive("radius");
}

void read_spline(SceneReader& reader, const TableReader& t) {
  t.only({"kind", "points", "closed", "through", "direction", "length", "axis_point", "axis",
          "radius", "mode", "material"});
  const Stock& stock = reader.scene.stock;
  SceneSpline made;
  made.line = t.line();
  if (!t.has("kind")) t.fail(t.full("kind") + " is missing");
  read_spline_shape(t, made.shape);
  if (t.failed()) return;
  t.choice("mode", made.operation);
  made.material = t.has("material") ? reader.material(t, "material") : stock.material;
  if (t.failed()) return;
  if (const auto fits = make_spline_mesh(made.shape, stock.pitch_mm); !fits)
    return t.fail("[spline]: " + fits.error());
  reader.scene.splines.push_back(std::move(made));
}

void read_cutter_shape(const TableReader& t, Cutter& cutter) {
  if (t.has("curve")) {
    CutCurve& cut = cutter.shape.emplace<CutCurve>();
    for (const char* key : {"point", "normal"})
      if (t.has(key)) t.fail(key, t.full(key) + " and curve exclude each other; give only one");
    cut.curve_mm = t.places("curve");
    if (t.has("along")) cut.along = t.vector("along");
    cut.closed = t.flag_or("closed", false);
    cut.smooth = t.flag_or("smooth", false);
  } else {
    cutter.shape = CutPlane{t.vector("point"), t.vector("normal")};
  }
  t.not_negative("kerf", cutter.kerf_mm);
}

void read_cutter(SceneReader& reader, const TableReader& t) {
  t.only({"point", "normal", "curve", "along", "closed", "smooth", "kerf", "body", "shift", "feed",
          "speed"});
  SceneCutter made;
  made.line = t.line();
  read_cutter_shape(t, made.cutter);
  if (t.has("body")) made.body = t.text("body");
  if (t.has("shift")) made.shift_mm = t.vector("shift");
  if (t.has("feed")) {
    const Vec3 feed = t.vector("feed");
    if (!(feed.norm() > 0)) t.fail("feed", "[cutter] feed must not be zero");
    made.feed = feed.normalized();
    made.speed_mm_s = t.positive("speed");
  } else if (t.has("speed")) {
    t.fail("speed", "[cutter] speed needs a direction: feed = [x, y, z]");
  }
  if (t.failed()) return;
  if (const Status fits = check_cutter(made.cutter); !fits)
    return t.fail("[cutter]: " + fits.error());
  reader.scene.cutters.push_back(std::move(made));
}

}  // namespace

void read_bodies(SceneReader& reader, const TableReader& root) {
  root.choice("crumbs", reader.scene.crumbs);
  root.for_tables("cutter", "cutters are written as [[cutter]]",
                  [&](const TableReader& t) { read_cutter(reader, t); });
  root.for_tables("spline", "splines are written as [[spline]]",
                  [&](const TableReader& t) { read_spline(reader, t); });
  root.for_tables("no_go", "protected regions are written as [[no_go]]",
                  [&](const TableReader& t) { read_no_go(reader, t); });
}

}  // namespace kibori
