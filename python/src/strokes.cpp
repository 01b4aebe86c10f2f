// SPDX-License-Identifier: MIT
// Moves tools along paths and returns the results as arrays.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>

#include <kibori/report/tick_row.h>
#include <kibori/motion/reshape_stroke.h>

#include "python/src/fields.h"
#include "python/src/materials.h"
#include "python/src/model.h"

namespace kibori::python {
namespace {

constexpr auto kBetweenSignals = std::chrono::milliseconds(50);

// Strokes are in world coordinates. A workpiece carves its active body in the body's coordinates.
Pose pose_of_active(Workpiece& piece) { return piece.bodies().find(piece.active())->pose; }

Wrench to_world(const Pose& body_pose, const Wrench& wrench) {
  return {body_pose.frame * wrench.force, body_pose.frame * wrench.moment};
}

// The keyword arguments of carve() and stroke().
struct StrokeChoice {
  StrokeSettings settings;
  std::optional<MaterialOrName> material;
  std::optional<Three> centre;
  std::string label;

  // Returns the settings for a workpiece, in the coordinates of its active body.
  StrokeSettings of(Workpiece& piece) const {
    StrokeSettings s = settings;
    s.material = number_of(piece, material);
    const Pose body_pose = pose_of_active(piece);
    const auto to_body = [&](const Vec3& place) -> Vec3 {
      return body_pose.frame.transpose() * (place - body_pose.tip);
    };
    s.symmetry.centre_mm = centre ? to_body(vec(*centre)) : centre_of(piece.model().lattice());
    s.brush.plane.point_mm = to_body(s.brush.plane.point_mm);
    s.brush.plane.normal = body_pose.frame.transpose() * s.brush.plane.normal;
    return s;
  }
};

StrokeChoice choice_of(const Tool& tool, const std::string& mode,
                       const std::optional<MaterialOrName>& material, const std::string& force,
                       int dof, double rate, const std::string& powered,
                       const std::optional<double>& thrust, const std::string& mirror, int fold,
                       const std::string& axis, const std::optional<Three>& centre,
                       const std::string& crumbs, const py::dict& brush, const std::string& label,
                       const py::dict& spring) {
  StrokeChoice choice;
  StrokeSettings& s = choice.settings;
  choice.label = label;
  choice.material = material;
  choice.centre = centre;
  s.tool = tool;
  s.mode = named<Mode>("mode", mode);
  s.force.law.model = named<ForceModel>("force model", force);
  if (dof != 5 && dof != 6) throw Failure("dof must be 5 or 6");
  s.force.law.dof = dof;
  if (!(rate > 0) || !(rate <= 1e6))
    throw Failure("rate is the number of ticks per second; it must be above 0, up to 1e6");
  s.rate_hz = rate;
  s.force.law.hand_share = share_of(powered);
  const bool energy = s.force.law.model == ForceModel::energy;
  if (thrust && !energy) throw Failure("thrust needs force='energy'");
  if (thrust && !(*thrust >= 0 && *thrust <= kMaxThrust)) throw Failure("thrust must be 0 to 3");
  s.force.law.thrust = energy ? thrust.value_or(kSharpThrust) : 0;
  for (const auto& [key, value] : spring) {
    const auto name = given<std::string>(key, "the keys of spring must be names");
    const auto number = given<double>(value, "the values of spring must be numbers");
    if (!(number >= 0) || !std::isfinite(number))
      throw Failure("a spring's " + sanitize_message(name) + " must be 0 or more");
    if (!set_field(s.force.spring, name, value, "the values of spring must be numbers") ||
        !(s.force.spring.stiffness_n_mm > 0))
      throw Failure(
          "a spring has a stiffness above 0 [N/mm], torsion [N mm/rad], friction and "
          "strength [N], not '" +
          sanitize_message(name) + "'");
  }
  s.force.spring.hand_share = s.force.law.hand_share;
  for (const char letter : mirror) {
    const size_t plane = std::string("xyz").find(letter);
    if (plane == std::string::npos) throw Failure("mirror must consist of letters of \"xyz\"");
    s.symmetry.planes[plane] = true;
  }
  s.symmetry.fold = fold;
  s.symmetry.axis = axis == "x" ? Axis::x : axis == "y" ? Axis::y : Axis::z;
  if (axis != "x" && axis != "y" && axis != "z")
    throw Failure("axis must be \"x\", \"y\" or \"z\"");
  s.crumbs = named<Crumbs>("rule for crumbs", crumbs);
  s.brush.strength = default_strength(s.mode);
  for (const auto& [key, value] : brush) {
    const auto name = given<std::string>(key, "the keys of brush must be names");
    const std::string what = "a brush's " + sanitize_message(name) + " has the wrong type";
    if (!set_field(s.brush, name, value, what))
      throw Failure("a brush has no '" + sanitize_message(name) + "'; it has " +
                    field_names<Brush>());
  }
  return choice;
}

struct Carved {
  py::array_t<double> removed_mm3, force, moment, poses;
  py::array_t<int64_t> points;
  double fallen_mm3 = 0;
  std::vector<BodyId> severed;
};

std::vector<BodyId> ids_from(Workpiece& piece, BodyId first) {
  std::vector<BodyId> ids;
  for (const Body& body : piece.bodies().all)
    if (body.id >= first) ids.push_back(body.id);
  return ids;
}

// A stroke in progress. Its destructor cancels it, unless keep() was called.
class Begun {
 public:
  Begun(Workpiece& piece, const StrokeChoice& choice, const Pose& start)
      : piece_(piece), materials_(piece.materials().size()) {
    const Status begun =
        piece.begin(choice.of(piece), pose_of_active(piece).from_world(start), choice.label);
    if (begun) return;
    piece.materials().resize(materials_);
    throw Failure(begun.error());
  }
  Begun(const Begun&) = delete;
  Begun& operator=(const Begun&) = delete;
  ~Begun() {
    if (kept_) return;
    piece_.cancel();
    piece_.materials().resize(materials_);
  }
  void keep() { kept_ = true; }

 private:
  Workpiece& piece_;
  const size_t materials_;
  bool kept_ = false;
};

Carved carve(Model& model, const StrokeChoice& choice, const std::vector<Pose>& path) {
  if (path.size() < 2)
    throw py::value_error("a path needs at least two rows: the start of the tool, and its targets");
  const auto sweeps = static_cast<py::ssize_t>(path.size() - 1);
  Carved carved;
  carved.removed_mm3 = py::array_t<double>(sweeps);
  carved.points = py::array_t<int64_t>(sweeps);
  carved.force = py::array_t<double>({sweeps, py::ssize_t{3}});
  carved.moment = py::array_t<double>({sweeps, py::ssize_t{3}});
  carved.poses = py::array_t<double>({sweeps, py::ssize_t{7}});
  double* const removed = carved.removed_mm3.mutable_data();
  int64_t* const points = carved.points.mutable_data();
  double *const force = carved.force.mutable_data(), *const moment = carved.moment.mutable_data(),
                *const poses = carved.poses.mutable_data();
  model.with([&](Workpiece& piece) {
    const BodyId next = piece.bodies().next;
    const Pose body_pose = pose_of_active(piece);
    Begun begun(piece, choice, path.front());
    auto checked_at = std::chrono::steady_clock::now();
    for (size_t i = 1; i < path.size(); i++) {
      if (const auto now = std::chrono::steady_clock::now(); now - checked_at > kBetweenSignals) {
        checked_at = now;
        const py::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
      Result<ToolTick> done = piece.advance(body_pose.from_world(path[i]));
      if (!done) throw Failure("row " + std::to_string(i) + " of the path: " + done.error());
      ToolTick& tick = done.value();
      const std::array<double, 7> pose = numbers_of(body_pose.to_world(tick.pose));
      if (i + 1 == path.size()) {
        const CrumbResult ended = value_of(piece.end(&tick));
        begun.keep();
        carved.fallen_mm3 = ended.fallen_mm3;
        if (!ended.portions.empty()) carved.severed = ids_from(piece, next);
      }
      removed[i - 1] = tick.removed_mm3;
      points[i - 1] = tick.points;
      const Wrench world = to_world(body_pose, tick.wrench);
      for (int k = 0; k < 3; k++) {
        force[3 * (i - 1) + static_cast<size_t>(k)] = world.force[k];
        moment[3 * (i - 1) + static_cast<size_t>(k)] = world.moment[k];
      }
      std::copy(pose.begin(), pose.end(), poses + 7 * (i - 1));
    }
  });
  return carved;
}

struct MoveResult {
  double removed_mm3 = 0;
  int64_t points = 0;
  Three force{}, moment{};
  std::array<double, 7> pose{};
};

// A stroke that the caller moves pose by pose.
class Stroke {
 public:
  Stroke(Shared model, const StrokeChoice& choice, const Pose& start) : model_(std::move(model)) {
    model_->with([&](Workpiece& piece) {
      body_pose_ = pose_of_active(piece);
      Begun(piece, choice, start).keep();
    });
    open_ = true;
  }
  Stroke(const Stroke&) = delete;
  Stroke& operator=(const Stroke&) = delete;
  // A stroke that was not ended is cancelled.
  ~Stroke() {
    try {
      cancel();
    } catch (const std::exception&) {
      // This thread is still in a call on the model.
    }
  }
  MoveResult move(const Pose& to) {
    if (!open_) throw Failure("this stroke has ended");
    return model_->with([&](Workpiece& piece) {
      const ToolTick tick = value_of(piece.advance(body_pose_.from_world(to)));
      const Wrench world = to_world(body_pose_, tick.wrench);
      return MoveResult{tick.removed_mm3, tick.points, three(world.force), three(world.moment),
                        numbers_of(body_pose_.to_world(tick.pose))};
    });
  }
  void end() {
    if (!open_) return;
    model_->with([&](Workpiece& piece) { value_of(piece.end()); });
    open_ = false;
  }
  void cancel() {
    if (!std::exchange(open_, false)) return;
    model_->with([&](Workpiece& piece) { piece.cancel(); });
  }

 private:
  Shared model_;
  Pose body_pose_;  // pose of the body that it carves
  bool open_ = false;
};

// All modes that reshape, with commas between them.
std::string reshaping_modes() {
  std::string modes;
  for (const std::string_view name : names_of(Mode{}))
    if (reshapes(*kibori::value_of<Mode>(name)))
      modes.append(modes.empty() ? "" : ", ").append(name);
  return modes;
}

// The help of Model.carve. reshaping_modes() is between the two parts.
const char* const kAboutCarve =
    "carve(tool, path, mode='cut', ...) -> Carved\n\n"
    "Moves a tool along a path, exactly from each pose to the next, as one stroke.\n\n"
    "path: array [N, 3] of tips, or [N, 7] of poses (x, y, z, and a quaternion x, y, z, w that "
    "turns the upright tool), in mm in the world, like all members of Carved. N rows give N - 1 "
    "sweeps.\n"
    "mode: cut, deposit, touch, off, or one that reshapes (";
const char* const kAboutCarveRest =
    ").\n"
    "material: name or Material that a deposit adds.\n"
    "force: energy (the law of the material, averaged over one cell of path), paper (-Kf K) or\n"
    "series (the path is that of the hand, and a spring pulls the tool); dof: 5 or 6; rate: ticks "
    "per\n"
    "second; powered: '', 'motor' or 'press'; thrust: for energy, the share of the cutting force\n"
    "that pushes the edge off (0.3; more for worn edges).\n"
    "mirror: mirror planes, letters of 'xyz'; fold, axis: number of copies about an axis. Planes "
    "and axis are those of the body. centre: a point of both [mm] in the world; default: the "
    "centre of the lattice.\n"
    "crumbs: rule for severed pieces: stay, sort, fall, body.\n"
    "spring: dict of stiffness [N/mm] (0.5), torsion [N mm/rad], friction, strength [N], for "
    "series.\n"
    "brush: for modes that reshape, dict of radius [mm], strength (0 to 1), falloff ('smooth', "
    "'linear', 'constant'), sigma [mm], keep_volume, spacing [radii], wall [mm], flatten_to, "
    "point, normal, color.\n\n"
    "Errors (kibori.Error, ValueError) leave the model unchanged. Other Python threads run "
    "meanwhile.";

// Defines a method of Model with the keyword arguments of a stroke. It calls f(model, choice,
// result of `convert` for the argument `path_name`).
template <class Convert, class F>
void def_stroke(ModelClass& model, const char* name, const char* path_name, Convert convert, F f,
                const char* about) {
  model.def(
      name,
      [=](const Shared& self, const Tool& tool, const Doubles& path, const std::string& mode,
          const std::optional<MaterialOrName>& material, const std::string& force, int dof,
          double rate, const std::string& powered, const std::optional<double>& thrust,
          const std::string& mirror, int fold, const std::string& axis,
          const std::optional<Three>& centre, const std::string& crumbs, const py::dict& brush,
          const std::string& label, const py::dict& spring) {
        const auto converted = convert(path);
        const StrokeChoice choice =
            choice_of(tool, mode, material, force, dof, rate, powered, thrust, mirror, fold, axis,
                      centre, crumbs, brush, label, spring);
        return f(self, choice, converted);
      },
      py::arg("tool"), py::arg(path_name), py::arg("mode") = "cut",
      py::arg("material") = py::none(), py::kw_only(), py::arg("force") = "energy",
      py::arg("dof") = 5, py::arg("rate") = 1000.0, py::arg("powered") = "",
      py::arg("thrust") = py::none(), py::arg("mirror") = "", py::arg("fold") = 1,
      py::arg("axis") = "z", py::arg("centre") = py::none(), py::arg("crumbs") = "stay",
      py::arg("brush") = py::dict(), py::arg("label") = "", py::arg("spring") = py::dict(), about);
}

}  // namespace

void bind_strokes(py::module_& module, ModelClass& model) {
  py::class_<Carved>(module, "Carved", "Result of a path, sweep by sweep.")
      .def_readonly("removed_mm3", &Carved::removed_mm3,
                    "[N-1] mm^3; negative if material was added.")
      .def_readonly("points", &Carved::points, "[N-1] lattice nodes that were removed or added.")
      .def_readonly("force", &Carved::force, "[N-1, 3] N, on the tool (series: on the hand).")
      .def_readonly("moment", &Carved::moment, "[N-1, 3] N mm, about the tip.")
      .def_readonly("poses", &Carved::poses,
                    "[N-1, 7] poses of the tool at the end of each sweep: x, y, z [mm] and a "
                    "quaternion x, y, z, w.")
      .def_readonly("fallen_mm3", &Carved::fallen_mm3,
                    "Volume that was severed and fell away [mm^3].")
      .def_readonly("severed", &Carved::severed,
                    "Numbers of the new bodies that the stroke severed.")
      .def("__len__", [](const Carved& carved) { return carved.removed_mm3.size(); });
  py::class_<MoveResult>(module, "Tick", "Result of one move of a stroke.")
      .def_readonly("removed_mm3", &MoveResult::removed_mm3,
                    "mm^3; negative if material was added.")
      .def_readonly("points", &MoveResult::points, "Lattice nodes that were removed or added.")
      .def_readonly("force", &MoveResult::force, "N, on the tool (series: on the hand).")
      .def_readonly("moment", &MoveResult::moment, "N mm, about the tip.")
      .def_readonly("pose", &MoveResult::pose, "x, y, z [mm] and a quaternion x, y, z, w.");
  py::class_<Stroke>(module, "Stroke",
                     "A stroke that a script moves pose by pose: see Model.stroke.")
      .def(
          "move", [](Stroke& self, const Doubles& pose) { return self.move(pose_of(pose)); },
          py::arg("pose"),
          "Moves the tool to a pose: x, y, z, or x, y, z and a quaternion. Returns a Tick.")
      .def("end", &Stroke::end, "Ends the stroke. It becomes one step of the history.")
      .def("cancel", &Stroke::cancel, "Discards the stroke. The model is restored.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__",
           [](Stroke& self, const py::object& type, const py::object&, const py::object&) {
             if (type.is_none())
               self.end();
             else
               self.cancel();
           });
  def_stroke(
      model, "carve", "path", poses_of,
      [](const Shared& self, const StrokeChoice& choice, const std::vector<Pose>& path) {
        return carve(*self, choice, path);
      },
      (kAboutCarve + reshaping_modes() + kAboutCarveRest).c_str());
  def_stroke(
      model, "stroke", "start", pose_of,
      [](const Shared& self, const StrokeChoice& choice, const Pose& start) {
        return std::make_unique<Stroke>(self, choice, start);
      },
      "stroke(tool, start, ...) -> Stroke\n\nThe same as carve(), moved pose by pose: with "
      "m.stroke(tool, "
      "start) "
      "as s: tick = s.move(pose).");
}

}  // namespace kibori::python
