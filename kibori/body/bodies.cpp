// SPDX-License-Identifier: MIT
#include <kibori/body/bodies.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/file.h>
#include <kibori/base/hash.h>
#include <kibori/body/pieces.h>
#include <kibori/body/placing.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/dexel_solid.h>
#include <kibori/solid/tool.h>

namespace kibori {
namespace {

constexpr double kFarthestMm = 1e6;  // maximum distance of a body or a position from the origin

bool same_pose(const Pose& a, const Pose& b) { return a.tip == b.tip && a.frame == b.frame; }

Pose relative(const Pose& of, const Pose& to) {
  const Mat3 back = to.frame.transpose();
  return {back * (of.tip - to.tip), back * of.frame};
}

// Materials that have a span, in order of their index.
std::vector<uint8_t> materials_of(const Snapshot& model) {
  std::vector<bool> there(kMaxMaterials, false);
  const FieldSnapshot& z = model.field(Axis::z);
  for (int tv = z.tv_begin(); tv < z.tv_end(); tv++)
    for (int tu = z.tu_begin(); tu < z.tu_end(); tu++) {
      const Tile& tile = z.tile(tu, tv);
      if (tile.empty) continue;
      if (tile.material != kMixedMaterial) {
        there[tile.material] = true;
        continue;
      }
      for (const Plane* p = &tile.first; p; p = p->next)
        for (int slot = 0; slot < kTileRays; slot++)
          if (!p->empty_at(slot)) there[p->material[slot]] = true;
    }
  std::vector<uint8_t> list;
  for (size_t i = 0; i < there.size(); i++)
    if (there[i]) list.push_back(static_cast<uint8_t>(i));
  return list;
}

// Copies paint from `other` to the ends that both have.
void take_paint(TriDexel& model, const Snapshot& other) {
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    const FieldSnapshot& from = other.field(axis);
    for (int tv = from.tv_begin(); tv < from.tv_end(); tv++)
      for (int tu = from.tu_begin(); tu < from.tu_end(); tu++) {
        const Tile& tile = from.tile(tu, tv);
        for (const Plane* p = &tile.first; p; p = p->next) {
          if (!p->paint) continue;
          for (int slot = 0; slot < kTileRays; slot++) {
            if (p->empty_at(slot) || !(p->paint->in[slot] | p->paint->out[slot])) continue;
            Tile& to = field.writable(tu, tv);
            for (Plane* q = &to.first; q && !q->empty_at(slot); q = q->next) {
              const bool in = q->in[slot] == p->in[slot], out = q->out[slot] == p->out[slot];
              if (!in && !out) continue;
              PaintPlane& paint = field.paint_of(*q);
              if (in) paint.in[slot] = p->paint->in[slot];
              if (out) paint.out[slot] = p->paint->out[slot];
            }
          }
        }
      }
  }
}

std::string quoted(const Body& body) {
  std::string text = "'";
  return text.append(sanitize_message(body.name)).append("'");
}

// One action on a copy of the document's list.
class Acting {
 public:
  Acting(BodyList& bodies, const BodyAction& action, int threads)
      : bodies_(bodies), action_(action), threads_(threads) {
    edit_.threads = threads;
  }

  Result<BodyChange> run() {
    // The result must not depend on how far a lattice had grown, but only on the content.
    for (Body& body : bodies_.all) {
      if (!body.model.lattice.grown()) continue;
      TriDexel model(body.model, body.material_bounds);
      model.set_lattice(fitted_lattice(body.model));
      put_back(body, model);
    }
    const auto check_and_act = [&](const auto& verb) -> Status {
      if (Status s = check_bodies(verb.kRule); !s) return s;
      if (Status s = check(verb); !s) return s;
      if (Status s = check_changed(verb.kRule); !s) return s;
      return act(verb);
    };
    if (Status s = std::visit(check_and_act, action_.verb); !s) return Error{s.error()};
    if (bodies_.all.size() > kMaxBodies)
      return Error{"this would make " + std::to_string(bodies_.all.size()) +
                   " bodies, and the limit is " + std::to_string(kMaxBodies)};
    return std::move(change_);
  }

 private:
  Status check_bodies(const BodyRule& rule) const {
    for (const BodyId id : action_.bodies) {
      const Body* body = bodies_.find(id);
      if (!body) return Error{"there is no body " + std::to_string(id)};
      if (std::count(action_.bodies.begin(), action_.bodies.end(), id) > 1)
        return Error{"body " + quoted(*body) + " is listed twice"};
    }
    if (action_.bodies.size() >= rule.fewest) return Ok{};
    return Error{rule.fewest > 1 ? "this action needs at least two bodies"
                                 : "this action needs a body"};
  }

  // Checks that the bodies to be changed may be changed.
  Status check_changed(const BodyRule& rule) const {
    size_t changed = rule.changes == BodyRule::Changes::all ? action_.bodies.size() : 0;
    if (rule.changes == BodyRule::Changes::first) changed = 1;
    for (size_t i = 0; i < changed; i++) {
      const Body& body = *bodies_.find(action_.bodies[i]);
      if (body.locked) return Error{"body " + quoted(body) + " is locked; unlock it first"};
      for (const Body& mask : bodies_.all)
        if (rule.places && mask.locked && moves_with(mask, body))
          return Error{"its mask " + quoted(mask) + " is locked; unlock it first"};
      if (body.no_go && !rule.of_no_go)
        return Error{"body " + quoted(body) + " is protected; allow cuts in it first"};
    }
    return Ok{};
  }

  // Additional checks of each verb.
  Status check(const BodyJoin&) const { return Ok{}; }
  Status check(const BodySubtract&) const { return Ok{}; }
  Status check(const BodyIntersect&) const { return Ok{}; }
  Status check(const BodySeparate&) const { return Ok{}; }
  Status check(const BodyDuplicate&) const { return Ok{}; }
  Status check(const BodyBake&) const { return Ok{}; }
  Status check(const BodyRemove&) const { return Ok{}; }
  Status check(const BodyCut& verb) const { return check_cutter(verb.cutter); }
  Status check(const BodyMirror& verb) const { return check_cutter({verb.plane}); }
  Status check(const BodyMove& verb) const { return check_pose(verb.pose); }
  Status check(const BodySet& verb) const { return check_name(verb.properties); }
  Status check(const BodyAdd& verb) const {
    if (!action_.bodies.empty())
      return Error{"an added body is separate; do not name other bodies"};
    if (Status s = check_tool(verb.tool); !s) return s;
    if (verb.material >= kMaxMaterials) return Error{"this material is unknown"};
    if (Status s = check_pose(verb.pose); !s) return s;
    return check_name(verb.properties);
  }
  Status check(const BodySpline& verb) const {
    if (action_.bodies.size() != 1) return Error{"a spline needs exactly one body"};
    if (verb.material >= kMaxMaterials) return Error{"this material is unknown"};
    return Ok{};
  }
  Status check(const BodyProtect& verb) const {
    if (action_.bodies.size() > 2)
      return Error{"a mask belongs to one body; name only that body and the mask"};
    if (verb.path_mm.empty()) return Error{"the path of the mask is missing"};
    if (Status s = check_tool(verb.tool); !s) return s;
    if (verb.path_mm.size() > kMaxPathPoints)
      return Error{"the path of a mask has at most " + std::to_string(kMaxPathPoints) + " points"};
    for (const Vec3& p : verb.path_mm)
      if (!(p.norm() < kFarthestMm))
        return Error{"a point of a mask's path is not finite, or too far away"};
    const Body& own = *bodies_.find(action_.bodies.front());
    if (own.no_go)
      return Error{"body " + quoted(own) + " is itself protected, so it needs no mask"};
    if (action_.bodies.size() == 2) {
      const Body& mask = *bodies_.find(action_.bodies[1]);
      if (!mask.no_go || mask.locked || !same_pose(mask.pose, own.pose))
        return Error{"body " + quoted(mask) + " is not a mask of body " + quoted(own)};
    } else if (verb.operation == SplineOperation::cut) {
      return Error{"this action needs the name of the mask"};
    }
    return check_name(verb.properties);
  }
  static Status check_pose(const Pose& pose) {
    if (is_rigid(pose)) return Ok{};
    return Error{"a body's pose must be a position and three unit axes at right angles"};
  }
  static Status check_name(const BodyProperties& properties) {
    if (properties.name && (properties.name->empty() || properties.name->size() > 100))
      return Error{"a body's name must have 1 to 100 bytes"};
    return Ok{};
  }

  Status act(const BodyJoin&) {
    return combine([&](TriDexel& model, const Body& other) {
      unite(model, other.model, other.material_bounds);
      for (Body& mask : bodies_.all)
        if (mask.mask_of == other.id) mask.mask_of = action_.bodies.front();
      remove(other.id);
    });
  }
  Status act(const BodySubtract&) {
    return combine([&](TriDexel& model, const Body& other) {
      Removed changed;
      cut(model, DexelSolid(other.model, other.material_bounds), edit_, changed);
    });
  }
  Status act(const BodyIntersect&) {
    return combine([&](TriDexel& model, const Body& other) {
      Removed changed;
      intersect(model, DexelSolid(other.model, other.material_bounds), edit_, changed);
    });
  }
  Status act(const BodySeparate&) {
    return each([&](Body& body) { return separate(body); });
  }
  Status act(const BodyDuplicate&) {
    return each([&](Body& body) {
      Body copy = body;
      copy.locked = copy.no_go = false;
      copy.mask_of = 0;
      add(std::move(copy), body.name + " copy");
      return Status(Ok{});
    });
  }
  // Mirrors each model in its own coordinates. Its pose does not change.
  Status act(const BodyMirror& verb) {
    return each_and_masks([&](Body& body) {
      const CutPlane plane = in_body(verb.plane, body.pose);
      const Vec3 n = plane.normal.normalized();
      const Mat3 flip = Mat3::Identity() - 2 * n * n.transpose();
      return place(body, {flip, 2 * n.dot(plane.point_mm) * n}, [] {});
    });
  }
  Status act(const BodyMove& verb) {
    return each([&](Body& body) {
      for (Body& mask : bodies_.all)
        if (moves_with(mask, body))
          mask.pose = same_pose(mask.pose, body.pose)
                          ? verb.pose
                          : verb.pose.to_world(body.pose.from_world(mask.pose));
      body.pose = verb.pose;
      return Status(Ok{});
    });
  }
  Status act(const BodyBake&) {
    return each_and_masks([&](Body& body) {
      return place(body, {body.pose.frame, body.pose.tip}, [&] { body.pose = Pose(); });
    });
  }
  Status act(const BodyRemove&) {
    for (const BodyId id : action_.bodies) remove(id);
    if (bodies_.all.empty()) return Error{"the last body can't be removed"};
    return Ok{};
  }
  Status act(const BodySet& verb) {
    const BodyProperties& to = verb.properties;
    return each([&](Body& body) {
      body.name = to.name.value_or(body.name);
      body.visible = to.visible.value_or(body.visible);
      body.locked = to.locked.value_or(body.locked);
      body.no_go = to.no_go.value_or(body.no_go);
      return Status(Ok{});
    });
  }

  template <class F>
  Status each(F&& f) {
    for (const BodyId id : action_.bodies) {
      Body body = *bodies_.find(id);
      if (Status s = f(body); !s) return s;
      *bodies_.find(id) = std::move(body);
    }
    return Ok{};
  }
  // A mask moves with its body, unless the action names the mask itself.
  bool moves_with(const Body& mask, const Body& body) const {
    return mask.mask_of == body.id && mask.no_go &&
           std::count(action_.bodies.begin(), action_.bodies.end(), mask.id) == 0;
  }
  template <class F>
  Status each_and_masks(F&& f) {
    return each([&](Body& body) -> Status {
      for (Body& mask : bodies_.all)
        if (moves_with(mask, body))
          if (Status s = f(mask); !s) return s;
      return f(body);
    });
  }
  void add(Body body, const std::string& name = {}) {
    body.id = bodies_.next++;
    body.name = name.empty() ? "Body " + std::to_string(body.id) : name;
    change_.made.push_back(body.id);
    bodies_.all.push_back(std::move(body));
  }
  // An empty model that shares the memory of the bodies. Its lattice holds all of theirs.
  TriDexel nothing() const {
    const Snapshot& any = bodies_.all.front().model;
    TriDexel model(any, LatticeBox());
    for (const Body& body : bodies_.all)
      model.set_lattice(joined(model.lattice(), body.model.lattice));
    for (const Axis axis : kAxes) {
      Field& field = model.field(axis);
      for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
        for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) field.clear_tile(tu, tv);
    }
    return model;
  }
  // Adds the volume that the tool sweeps along the path, in the body's frame.
  void sweep_path(const BodyProtect& verb, TriDexel& model, const Pose& body) {
    const Lattice& lattice = model.lattice();
    const Pose back = body.from_world(Pose());
    Removed made;
    for (size_t i = 0; i < verb.path_mm.size(); i++) {
      const Vec3 from = back.to_world(verb.path_mm[i]),
                 to = back.to_world(verb.path_mm[std::min(i + 1, verb.path_mm.size() - 1)]);
      if (i > 0 && from == to) continue;
      const SweptTool solid(verb.tool, {from, back.frame}, Vec3(to - from), lattice);
      deposit(model, solid.solid(), 0, edit_, made);
    }
  }
  Status act(const BodyProtect& verb) {
    const Body& own = *bodies_.find(action_.bodies.front());
    TriDexel region = nothing();
    sweep_path(verb, region, own.pose);
    const bool more = verb.operation != SplineOperation::cut;
    Body* const mask = action_.bodies.size() > 1 ? bodies_.find(action_.bodies[1]) : nullptr;
    Removed changed;
    TriDexel model = nothing();
    if (mask) unite(model, mask->model, mask->material_bounds);
    if (more) {
      TriDexel held(own.model, own.material_bounds);
      intersect(held, DexelSolid(region.snapshot(), region.material_bounds()), edit_, changed);
      if (held.empty()) return Error{"body " + quoted(own) + " has no material to protect there"};
      unite(model, held.snapshot(), held.material_bounds());
    } else {
      cut(model, DexelSolid(region.snapshot(), region.material_bounds()), edit_, changed);
    }
    if (mask && model.content_hash() == mask->model.content_hash())
      return Error{more ? "this part is already protected" : "nothing is protected there"};
    if (!mask) {
      Body made;
      made.no_go = true;
      if (verb.follows) made.mask_of = own.id;
      made.pose = own.pose;
      put_back(made, model);
      add(std::move(made), verb.properties.name.value_or("Mask"));
    } else if (!model.empty()) {
      put_back(*mask, model);
    } else {
      remove(mask->id);
    }
    return Ok{};
  }
  Status act(const BodyAdd& verb) {
    TriDexel model = nothing();
    Removed made;
    const SweptTool solid(verb.tool, verb.pose, Vec3::Zero(), model.lattice());
    deposit(model, solid.solid(), verb.material, edit_, made);
    if (made.points() == 0) return Error{"the added body has no material within the lattice"};
    change_.clipped |= made.clipped;
    Body body;
    body.no_go = verb.properties.no_go.value_or(false);
    body.visible = verb.properties.visible.value_or(true);
    put_back(body, model);
    add(std::move(body), verb.properties.name.value_or(std::string()));
    return Ok{};
  }
  Status act(const BodySpline& verb) {
    return each([&](Body& body) { return shape_by_spline(verb, body); });
  }
  Status shape_by_spline(const BodySpline& verb, Body& body) {
    SplineShape there = verb.shape;
    const Pose back = body.pose.from_world(Pose());
    for (Vec3& p : there.curve.points_mm) p = back.to_world(p);
    there.axis_point_mm = back.to_world(there.axis_point_mm);
    there.axis = back.frame * there.axis;
    there.direction = back.frame * there.direction;
    TriDexel model(body.model, body.material_bounds);
    const double before = model.volume_mm3();
    SplineOptions options;
    options.threads = std::clamp(threads_, 1, 3);
    const Result<Removed> done = apply_spline(model, there, verb.operation, verb.material, options);
    if (!done) return Error{done.error()};
    if (verb.operation != SplineOperation::deposit) {
      const Result<std::shared_ptr<const NoGo>> no_go = no_go_of(bodies_, body.id);
      if (!no_go) return Error{no_go.error()};
      if (no_go.value()) {
        // Restores the body's protected part.
        TriDexel kept(body.model, body.material_bounds);
        Removed ignored;
        intersect(kept, no_go.value()->solid(), edit_, ignored);
        unite(model, kept.snapshot(), kept.material_bounds());
      }
    }
    const double after = model.volume_mm3();
    if (model.content_hash() == body.model.content_hash())
      return Error{"the spline's shape does not change body " + quoted(body)};
    if (model.empty()) return Error{"the spline's shape would remove all of body " + quoted(body)};
    change_.removed_mm3 += before - after;
    change_.clipped |= verb.operation == SplineOperation::deposit && done.value().clipped;
    put_back(body, model);
    return Ok{};
  }
  void unite(TriDexel& model, const Snapshot& other, const LatticeBox& bounds) {
    Removed changed;
    model.set_lattice(joined(model.lattice(), other.lattice));
    for (const uint8_t material : materials_of(other))
      deposit(model, DexelSolid(other, bounds, material), material, edit_, changed);
    take_paint(model, other);
  }
  void remove(BodyId id) {
    std::erase_if(bodies_.all, [&](const Body& body) { return body.id == id; });
    change_.gone.push_back(id);
  }
  void put_back(Body& body, const TriDexel& model) {
    body.model = model.snapshot();
    body.material_bounds = model.material_bounds();
  }

  Status act(const BodyCut& verb) {
    std::vector<BodyId> ids = action_.bodies;
    if (ids.empty())
      for (const Body& body : bodies_.all)
        if (body.visible && !body.kept()) ids.push_back(body.id);
    bool any = false;
    for (const BodyId id : ids) {
      Body body = *bodies_.find(id);
      TriDexel model(body.model, body.material_bounds);
      const CutOff off = cut_off(model, in_body(verb.cutter, body.pose), threads_);
      if (off.portions.empty() && off.removed_mm3 == 0) continue;
      any = true;
      change_.removed_mm3 += off.removed_mm3;
      change_.area_mm2 += off.area_mm2;
      put_back(body, model);
      *bodies_.find(id) = body;
      for (const BodyId made : add_bodies(bodies_, body.pose, off.portions))
        change_.made.push_back(made);
    }
    return any ? Status(Ok{}) : Status(Error{"the cutter does not meet a body"});
  }

  Status separate(Body& body) {
    const Pieces pieces = find_pieces(body.model);
    if (pieces.all().size() < 2) return Error{"body " + quoted(body) + " is in one piece"};
    size_t largest = 0;
    for (size_t i = 1; i < pieces.all().size(); i++)
      if (pieces.all()[i].nodes > pieces.all()[largest].nodes) largest = i;
    if (bodies_.all.size() + pieces.all().size() - 1 > kMaxBodies)
      return Error{"body " + quoted(body) + " is in " + std::to_string(pieces.all().size()) +
                   " pieces, and the limit is " + std::to_string(kMaxBodies) + " bodies"};
    std::vector<int> to;
    int count = 0;
    for (size_t i = 0; i < pieces.all().size(); i++) to.push_back(i == largest ? kStays : count++);
    TriDexel rest(body.model, body.material_bounds);
    std::vector<Portion> portions;
    for (Snapshot& off : part_pieces(rest, pieces, to, threads_))
      portions.push_back({std::move(off), rest.material_bounds()});
    put_back(body, rest);
    for (const BodyId made : add_bodies(bodies_, body.pose, portions)) change_.made.push_back(made);
    return Ok{};
  }

  // Calls f(model of the first body, other body). The other is placed at the first one's pose.
  template <class F>
  Status combine(F&& f) {
    Body first = *bodies_.find(action_.bodies.front());
    TriDexel model(first.model, first.material_bounds);
    for (size_t i = 1; i < action_.bodies.size(); i++) {
      Body other = *bodies_.find(action_.bodies[i]);
      if (!same_pose(first.pose, other.pose)) {
        const Pose there = relative(other.pose, first.pose);
        if (Status s = place(other, {there.frame, there.tip}, [] {}); !s) return s;
      }
      f(model, other);
    }
    put_back(first, model);
    *bodies_.find(first.id) = first;
    return Ok{};
  }

  template <class F>
  Status place(Body& body, const Affine& to, F&& done) {
    Result<Placed> placed = place_model(body.model, to, threads_);
    if (!placed) return Error{"body " + quoted(body) + ": " + placed.error()};
    // A mask may become empty.
    if (placed.value().model->material_bounds().empty() && body.mask_of == 0)
      return Error{"body " + quoted(body) + ": there is no material left"};
    change_.clipped |= placed.value().clipped;
    put_back(body, *placed.value().model);
    done();
    return Ok{};
  }

  BodyList& bodies_;
  const BodyAction& action_;
  const int threads_;
  EditOptions edit_;
  BodyChange change_;
};

}  // namespace

std::optional<BodyVerb> default_verb(std::string_view name) {
  std::optional<BodyVerb> verb;
  const auto take = [&]<size_t... I>(std::index_sequence<I...>) {
    static_cast<void>(((name == kBodyVerbs[I] && (verb.emplace().emplace<I>(), true)) || ...));
  };
  take(std::make_index_sequence<std::variant_size_v<BodyVerb>>());
  return verb;
}

bool is_rigid(const Pose& pose) {
  return pose.tip.allFinite() && pose.tip.norm() < kFarthestMm && pose.frame.allFinite() &&
         (pose.frame.transpose() * pose.frame - Mat3::Identity()).norm() < 1e-9 &&
         pose.frame.determinant() > 0;
}

Body* BodyList::find(BodyId id) {
  for (Body& body : all)
    if (body.id == id) return &body;
  return nullptr;
}

const Body* BodyList::find(BodyId id) const {
  for (const Body& body : all)
    if (body.id == id) return &body;
  return nullptr;
}

BodyList BodyList::of(const TriDexel& model) {
  BodyList bodies;
  bodies.all.emplace_back();
  bodies.all.back().model = model.snapshot();
  bodies.all.back().material_bounds = model.material_bounds();
  return bodies;
}

uint64_t BodyList::content_hash() const {
  if (all.size() == 1) return all.front().model.content_hash();
  Hash hash;
  for (const Body& body : all) hash.add(body.model.content_hash());
  return hash.value();
}

double BodyList::volume_mm3() const {
  double sum = 0;
  for (const Body& body : all) sum += body.model.volume_mm3();
  return sum;
}

Result<BodyChange> apply(BodyList& bodies, const BodyAction& action, int threads) {
  BodyList changed = bodies;
  Result<BodyChange> done = Acting(changed, action, threads).run();
  if (done) bodies = std::move(changed);
  return done;
}

Result<std::shared_ptr<const NoGo>> no_go_of(const BodyList& bodies, BodyId worked_on) {
  const Body& own = *bodies.find(worked_on);
  std::unique_ptr<TriDexel> all;
  for (const Body& body : bodies.all) {
    if (!body.no_go || body.id == worked_on || body.model.empty()) continue;
    if (!all) all = std::make_unique<TriDexel>(fitted_lattice(own.model));
    all->set_lattice(joined(all->lattice(), fitted_lattice(body.model)));
    Removed put_down;
    if (same_pose(body.pose, own.pose)) {
      deposit(*all, DexelSolid(body.model, body.material_bounds), 0, {}, put_down);
      continue;
    }
    const Pose there = relative(body.pose, own.pose);
    const Result<Placed> placed = place_model(body.model, {there.frame, there.tip});
    if (!placed)
      return Error{"body " + quoted(body) +
                   " is protected, but cannot be placed: " + placed.error()};
    const TriDexel& model = *placed.value().model;
    if (model.material_bounds().empty()) continue;
    deposit(*all, DexelSolid(model.snapshot(), model.material_bounds()), 0, {}, put_down);
  }
  if (!all) return std::shared_ptr<const NoGo>();
  return std::shared_ptr<const NoGo>(std::make_shared<NoGo>(std::move(all)));
}

namespace {

// True if a piece of `z` reaches into the protected region.
bool holds_some(const Pieces& pieces, int piece, const FieldSnapshot& z, const NoGo& no_go) {
  const NodeBounds& box = pieces.all()[static_cast<size_t>(piece)].box;
  const LatticeBox& there = no_go.bounds();
  if ((box.max.cast<double>() + 1 < there.units.min.array()).any() ||
      (box.min.cast<double>() > there.units.max.array()).any())
    return false;
  const FieldSnapshot& kept = no_go.model().field(Axis::z).view();
  for (int v = box.min.y(); v <= box.max.y(); v++)
    for (int u = box.min.x(); u <= box.max.x(); u++) {
      if (!kept.has_ray(u, v)) continue;
      int number = 0;
      bool meets = false;
      z.for_spans(u, v, [&](const Span& span) {
        if (pieces.of_span(u, v, number++) != piece) return;
        kept.for_spans(u, v, [&](const Span& other) {
          meets |= std::max(span.in, other.in) < std::min(span.out, other.out);
        });
      });
      if (meets) return true;
    }
  return false;
}

}  // namespace

CrumbResult take_crumbs(TriDexel& model, const Snapshot& before, Crumbs rule, const NoGo* no_go,
                        int threads) {
  CrumbResult result;
  if (rule == Crumbs::stay) return result;
  const Snapshot after = model.snapshot();
  const Severed severed = find_severed(before, after, threads);
  if (severed.parts.empty()) return result;
  std::vector<int> to(severed.pieces.all().size(), kStays);
  int portions = 0;
  for (const Severed::Part& part : severed.parts) {
    if (no_go && holds_some(severed.pieces, part.piece, after.field(Axis::z), *no_go)) continue;
    const bool falls = rule == Crumbs::fall || (rule == Crumbs::sort && part.share < kCrumbShare);
    result.fallen += falls;
    to[static_cast<size_t>(part.piece)] = falls ? kGone : portions++;
  }
  if (result.fallen == 0 && portions == 0) return result;
  for (Snapshot& off : part_pieces(model, severed.pieces, to, threads))
    result.portions.push_back({std::move(off), model.material_bounds()});
  if (result.fallen == 0) return result;
  double taken = 0;
  for (const Portion& portion : result.portions) taken += portion.model.volume_mm3();
  result.fallen_mm3 = std::max(0.0, -model.snapshot().volume_mm3_since(after) - taken);
  return result;
}

std::vector<BodyId> add_bodies(BodyList& bodies, const Pose& pose,
                               const std::vector<Portion>& portions) {
  std::vector<BodyId> made;
  // Creates all new bodies before the list grows. Growth moves the bodies in memory, and `pose` may
  // be in one of them.
  std::vector<Body> added;
  for (const Portion& portion : portions) {
    Body& body = added.emplace_back();
    body.id = bodies.next++;
    body.name = "Body " + std::to_string(body.id);
    body.pose = pose;
    body.model = portion.model;
    body.material_bounds = portion.material_bounds;
    made.push_back(body.id);
  }
  for (Body& body : added) bodies.all.push_back(std::move(body));
  return made;
}

}  // namespace kibori
