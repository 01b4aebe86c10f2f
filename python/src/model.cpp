// SPDX-License-Identifier: MIT
#include "python/src/model.h"

#include <cmath>
#include <limits>

#include <kibori/batch/convert.h>
#include <kibori/batch/stock.h>
#include <kibori/edit/edit.h>
#include <kibori/geometry/label_volume.h>
#include <kibori/haptics/materials.h>
#include <kibori/measure/distance.h>
#include <kibori/measure/mass.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/picture/picture.h>
#include <kibori/formats/png_file.h>
#include <kibori/solid/grid_solid.h>
#include <kibori/surface/layers.h>
#include <kibori/surface/surface.h>

#include "python/src/tools.h"

namespace kibori::python {
namespace {

constexpr int kRowsBetweenSignals = 256;

using Shared = std::shared_ptr<Model>;
using MaterialOrName = std::variant<Material, std::string>;

Material material_named(const MaterialOrName& wanted) {
  if (const auto* const own = std::get_if<Material>(&wanted)) return *own;
  const std::string& name = std::get<std::string>(wanted);
  std::string known;
  for (const Material& material : known_materials()) {
    if (material.name == name) return material;
    known += known.empty() ? material.name : ", " + material.name;
  }
  throw Failure("no material is called '" + sanitize_message(name) + "'; known are " + known +
                ", or make one: kibori.Material(name=..., u=...)");
}

// Its number in the piece's list, where it is put if it is not there.
uint8_t number_of(Workpiece& piece, const std::optional<MaterialOrName>& wanted) {
  if (!wanted) return 0;
  std::vector<Material>& all = piece.materials();
  const auto* const name = std::get_if<std::string>(&*wanted);
  const auto there = std::find_if(all.begin(), all.end(), [&](const Material& material) {
    return name ? material.name == *name : material == std::get<Material>(*wanted);
  });
  if (there != all.end()) return static_cast<uint8_t>(there - all.begin());
  if (all.size() >= kMaxMaterials)
    throw Failure("a piece has at most " + std::to_string(kMaxMaterials) + " materials");
  all.push_back(material_named(*wanted));
  return static_cast<uint8_t>(all.size() - 1);
}

template <class Enum>
Enum named(const std::string& what, const std::string& name) {
  const auto value = kibori::value_of<Enum>(name);
  if (value) return *value;
  std::string known;
  for (const std::string_view& one : names_of(Enum())) {
    if (!known.empty()) known += ", ";
    known += one;
  }
  throw Failure("there is no " + what + " '" + sanitize_message(name) + "'; there are " + known);
}

Shared shared(Result<std::unique_ptr<Workpiece>> piece) {
  return std::make_shared<Model>(value_of(std::move(piece)));
}

Shared make_stock_of(Stock stock, const MaterialOrName& material, int threads) {
  const std::vector<Material> materials{material_named(material)};
  const py::gil_scoped_release no_gil;
  return shared(Workpiece::make(stock, materials, threads));
}

Shared block(const Three& size, double pitch, const MaterialOrName& material,
             const std::optional<double>& room, int threads) {
  Stock stock;
  stock.size_mm = vec(size);
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared sphere(double diameter, double pitch, const MaterialOrName& material,
              const std::optional<double>& room, int threads) {
  Stock stock;
  stock.kind = Stock::Kind::sphere;
  stock.size_mm = Vec3::Constant(diameter);
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared cylinder(double diameter, double height, double pitch, const MaterialOrName& material,
                const std::optional<double>& room, int threads) {
  Stock stock;
  stock.kind = Stock::Kind::cylinder;
  stock.size_mm = Vec3(diameter, diameter, height);
  stock.pitch_mm = pitch;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared mesh_file(const std::filesystem::path& path, double pitch, const MaterialOrName& material,
                 const std::optional<double>& fit, const std::optional<double>& room, int threads) {
  Stock stock;
  stock.kind = Stock::Kind::mesh;
  stock.mesh_path = path;
  stock.pitch_mm = pitch;
  stock.fit_mm = fit;
  stock.room_mm = room;
  return make_stock_of(stock, material, threads);
}

Shared mesh_arrays(const Doubles& vertices, const Indices& triangles, double pitch,
                   const MaterialOrName& material, const std::optional<double>& room, int threads) {
  const TriangleMesh mesh = mesh_of(vertices, triangles);
  const std::vector<Material> materials{material_named(material)};
  const py::gil_scoped_release no_gil;
  const double room_mm = room.value_or(0.1 * mesh.bounds().size().maxCoeff());
  MeshStock made = value_of(stock_of_mesh(mesh, pitch, room_mm, 0, threads, false));
  return shared(Workpiece::of(std::move(made.model), materials));
}

// Labels [x, y, z]; 0 is air.
Shared volume(const py::array& given_labels, const Three& voxel, double pitch,
              const std::map<uint16_t, MaterialOrName>& of, const std::optional<double>& room,
              int threads) {
  const char kind = given_labels.dtype().kind();
  if (given_labels.ndim() != 3 || (kind != 'b' && kind != 'u' && kind != 'i'))
    throw py::value_error("a volume is an array of labels [x, y, z]: whole numbers, 0 is air");
  const auto labels =
      py::array_t<int64_t, py::array::c_style | py::array::forcecast>::ensure(given_labels);
  if (!labels) throw py::error_already_set();
  LabelVolume volume;
  volume.voxel_mm = vec(voxel);
  for (int i = 0; i < 3; i++) {
    const py::ssize_t size = labels.shape(i);
    if (size < 1 || size > 2048) throw Failure("a volume has 1 to 2048 voxels along each axis");
    volume.size[i] = static_cast<int>(size);
    if (!(volume.voxel_mm[i] > 0) || !(volume.voxel_mm[i] < 1e6))
      throw Failure("voxels are so many mm: more than 0");
  }
  const auto at = labels.unchecked<3>();
  volume.values.reserve(static_cast<size_t>(labels.size()));
  for (int z = 0; z < volume.size.z(); z++)
    for (int y = 0; y < volume.size.y(); y++)
      for (int x = 0; x < volume.size.x(); x++) {
        if (at(x, y, z) < 0 || at(x, y, z) > 65535) throw Failure("labels are 0 to 65535");
        volume.values.push_back(static_cast<uint16_t>(at(x, y, z)));
      }
  const std::vector<uint16_t> known = labels_of(volume);
  if (known.empty()) throw Failure("the volume holds nothing but air");
  std::vector<Material> materials;
  for (const uint16_t label : known) {
    const auto material = of.find(label);
    if (material == of.end() && !of.empty())
      throw Failure("materials does not say what label " + std::to_string(label) + " is of");
    materials.push_back(material == of.end() ? material_named(std::string("limewood"))
                                             : material_named(material->second));
  }
  if (materials.size() > kMaxMaterials)
    throw Failure("a piece has at most " + std::to_string(kMaxMaterials) + " materials");
  std::map<uint16_t, uint8_t> numbers;
  for (size_t i = 0; i < known.size(); i++) numbers[known[i]] = static_cast<uint8_t>(i);
  const py::gil_scoped_release no_gil;
  return shared(
      Workpiece::of(value_of(stock_of_labels(volume, numbers, pitch, room, threads)), materials));
}

// ---- Carving

// What the keywords of carve() and stroke() say.
struct StrokeChoice {
  StrokeSettings settings;
  std::optional<MaterialOrName> material;
  std::optional<Three> centre;
  std::string label;

  // Of a piece.
  StrokeSettings of(Workpiece& piece) const {
    StrokeSettings s = settings;
    s.material = number_of(piece, material);
    s.symmetry.centre_mm = centre ? vec(*centre) : centre_of(piece.model().lattice());
    return s;
  }
};

StrokeChoice choice_of(const Tool& tool, const std::string& mode,
                       const std::optional<MaterialOrName>& material, const std::string& force,
                       int dof, double rate, const std::string& powered, const std::string& mirror,
                       int fold, const std::string& axis, const std::optional<Three>& centre,
                       const std::string& crumbs, const py::dict& brush, const std::string& label) {
  StrokeChoice choice;
  StrokeSettings& s = choice.settings;
  choice.label = label;
  choice.material = material;
  choice.centre = centre;
  s.tool = tool;
  s.mode = named<Mode>("mode", mode);
  s.force.law.model = named<ForceModel>("force model", force);
  if (dof != 5 && dof != 6) throw Failure("dof is 5 or 6");
  s.force.law.dof = dof;
  if (!(rate > 0) || !(rate <= 1e6)) throw Failure("rate is so many ticks a second, up to 1e6");
  s.rate_hz = rate;
  if (powered == "motor")
    s.force.law.hand_share = kPoweredShare;
  else if (powered == "press")
    s.force.law.hand_share = kPressShare;
  else if (!powered.empty())
    throw Failure("powered is \"motor\", \"press\" or nothing");
  s.force.spring.hand_share = s.force.law.hand_share;
  for (const char letter : mirror) {
    const size_t plane = std::string("xyz").find(letter);
    if (plane == std::string::npos) throw Failure("mirror names planes by letters of \"xyz\"");
    s.symmetry.planes[plane] = true;
  }
  s.symmetry.fold = fold;
  s.symmetry.axis = axis == "x" ? Axis::x : axis == "y" ? Axis::y : Axis::z;
  if (axis != "x" && axis != "y" && axis != "z") throw Failure("axis is \"x\", \"y\" or \"z\"");
  s.crumbs = named<Crumbs>("rule for crumbs", crumbs);
  s.brush.strength = default_strength(s.mode);
  for (const auto& [key, value] : brush) {
    const auto name = given<std::string>(key, "what a brush has is called by a name");
    const std::string what = "a brush's " + sanitize_message(name) + " is not of that kind";
    const auto number = [&] { return given<double>(value, what); };
    const auto word = [&] { return given<std::string>(value, what); };
    if (name == "radius")
      s.brush.radius_mm = number();
    else if (name == "strength")
      s.brush.strength = number();
    else if (name == "falloff")
      s.brush.falloff = named<Falloff>("falloff", word());
    else if (name == "sigma")
      s.brush.sigma_mm = number();
    else if (name == "keep_volume")
      s.brush.keep_volume = given<bool>(value, what);
    else if (name == "spacing")
      s.brush.spacing = number();
    else if (name == "wall")
      s.brush.wall_mm = number();
    else if (name == "flatten_to")
      s.brush.flatten_to = named<FlattenTo>("plane", word());
    else if (name == "point")
      s.brush.plane.point_mm = vec(given<Three>(value, what));
    else if (name == "normal")
      s.brush.plane.normal = vec(given<Three>(value, what));
    else if (name == "color")
      s.brush.color = given<std::array<uint8_t, 3>>(value, what);
    else
      throw Failure("a brush has no '" + sanitize_message(name) +
                    "'; it has radius, strength, falloff, sigma, keep_volume, spacing, wall, "
                    "flatten_to, point, normal, color");
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
  for (const Body& body : piece.bench().bodies().all)
    if (body.id >= first) ids.push_back(body.id);
  return ids;
}

Carved carve(Model& model, const StrokeChoice& choice, const std::vector<Pose>& path) {
  if (path.size() < 2)
    throw py::value_error("a path has two rows at least: where the tool starts, and where it goes");
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
    const BodyId next = piece.bench().bodies().next;
    must(piece.begin(choice.of(piece), path.front(), choice.label));
    // All of it, or nothing.
    const auto stop = [&](const std::string& why) {
      piece.cancel();
      throw Failure(why);
    };
    for (size_t i = 1; i < path.size(); i++) {
      Result<ToolTick> done = piece.advance(path[i]);
      if (!done) stop("row " + std::to_string(i) + " of the path: " + done.error());
      ToolTick& tick = done.value();
      const std::array<double, 7> pose = seven(tick.pose);
      if (i + 1 == path.size()) {
        const Result<CrumbResult> ended = piece.end(&tick);
        if (!ended) stop(ended.error());
        carved.fallen_mm3 = ended.value().fallen_mm3;
        if (!ended.value().portions.empty()) carved.severed = ids_from(piece, next);
      }
      removed[i - 1] = tick.removed_mm3;
      points[i - 1] = tick.points;
      for (int k = 0; k < 3; k++) {
        force[3 * (i - 1) + static_cast<size_t>(k)] = tick.wrench.force[k];
        moment[3 * (i - 1) + static_cast<size_t>(k)] = tick.wrench.moment[k];
      }
      std::copy(pose.begin(), pose.end(), poses + 7 * (i - 1));
      if (i % kRowsBetweenSignals == 0) {
        const py::gil_scoped_acquire gil;
        if (PyErr_CheckSignals() != 0) {
          piece.cancel();
          throw py::error_already_set();
        }
      }
    }
  });
  return carved;
}

struct Felt {
  double removed_mm3 = 0;
  int64_t points = 0;
  Three force{}, moment{};
  std::array<double, 7> pose{};
};

// A stroke that is led pose by pose.
class Stroke {
 public:
  Stroke(Shared model, const StrokeChoice& choice, const Pose& start) : model_(std::move(model)) {
    model_->with(
        [&](Workpiece& piece) { must(piece.begin(choice.of(piece), start, choice.label)); });
    open_ = true;
  }
  Felt move(const Pose& to) {
    if (!open_) throw Failure("this stroke has ended");
    return model_->with([&](Workpiece& piece) {
      const ToolTick tick = value_of(piece.advance(to));
      return Felt{tick.removed_mm3, tick.points, three(tick.wrench.force),
                  three(tick.wrench.moment), seven(tick.pose)};
    });
  }
  void end() {
    if (!std::exchange(open_, false)) return;
    model_->with([&](Workpiece& piece) { value_of(piece.end()); });
  }
  void cancel() {
    if (!std::exchange(open_, false)) return;
    model_->with([&](Workpiece& piece) { piece.cancel(); });
  }

 private:
  Shared model_;
  bool open_ = false;
};

// ---- What can be looked at

// A state of the active body; it does not change, and outlives its model.
struct State {
  kibori::Snapshot snapshot;
};

// Arrays that share the memory of one Surface.
struct SurfaceArrays {
  py::array_t<float> vertices, normals;
  py::array_t<uint32_t> triangles, paint;
  py::array_t<uint8_t> materials;
};

SurfaceArrays surface_of_state(const kibori::Snapshot& snapshot, int threads) {
  auto* const surface = new Surface;
  const py::capsule owner(surface, [](void* p) { delete static_cast<Surface*>(p); });
  {
    const py::gil_scoped_release no_gil;
    *surface = extract_surface(snapshot, threads);
  }
  const auto count = static_cast<py::ssize_t>(surface->vertices.size());
  constexpr auto kStep = static_cast<py::ssize_t>(sizeof(SurfaceVertex));
  static SurfaceVertex none;
  const SurfaceVertex* const first = count > 0 ? surface->vertices.data() : &none;
  const auto floats = [&](const std::array<float, 3>& of) {
    return py::array_t<float>({count, py::ssize_t{3}}, {kStep, py::ssize_t{sizeof(float)}},
                              of.data(), owner);
  };
  SurfaceArrays all;
  all.vertices = floats(first->position);
  all.normals = floats(first->normal);
  all.materials = py::array_t<uint8_t>({count}, {kStep}, &first->material, owner);
  all.paint = py::array_t<uint32_t>({count}, {kStep}, &first->paint, owner);
  const auto triangles = static_cast<py::ssize_t>(surface->triangles.size());
  static uint32_t nobody[3];
  all.triangles =
      py::array_t<uint32_t>({triangles, py::ssize_t{3}},
                            {py::ssize_t{3 * sizeof(uint32_t)}, py::ssize_t{sizeof(uint32_t)}},
                            triangles > 0 ? surface->triangles.front().data() : nobody, owner);
  return all;
}

std::array<py::ssize_t, 3> shape_of(const Lattice& lattice) {
  return {lattice.nodes.x(), lattice.nodes.y(), lattice.nodes.z()};
}

// Calls f(index of [x, y, z]) for every node that is inside.
template <class F>
void for_inside(const kibori::Snapshot& state, F&& f) {
  const Index3& nodes = state.lattice.nodes;
  const FieldSnapshot& z = state.field(Axis::z);
  for (int x = 0; x < nodes.x(); x++)
    for (int y = 0; y < nodes.y(); y++)
      z.for_spans(x, y, [&](const Span& span) {
        // Nodes stand at k + 1/2.
        const int first = std::max(0, static_cast<int>(std::ceil(double{span.in} - 0.5)));
        for (int k = first; k < nodes.z() && k + 0.5 < double{span.out}; k++)
          f((static_cast<size_t>(x) * static_cast<size_t>(nodes.y()) + static_cast<size_t>(y)) *
                static_cast<size_t>(nodes.z()) +
            static_cast<size_t>(k));
      });
}

size_t node_count(const Lattice& lattice) {
  return static_cast<size_t>(lattice.nodes.x()) * static_cast<size_t>(lattice.nodes.y()) *
         static_cast<size_t>(lattice.nodes.z());
}

py::array_t<bool> occupancy(const kibori::Snapshot& state) {
  const auto shape = shape_of(state.lattice);
  py::array_t<bool> nodes(shape);
  bool* const data = nodes.mutable_data();
  const py::gil_scoped_release no_gil;
  std::fill_n(data, node_count(state.lattice), false);
  for_inside(state, [&](size_t i) { data[i] = true; });
  return nodes;
}

py::array_t<float> signed_distance(const kibori::Snapshot& state, int threads) {
  const auto shape = shape_of(state.lattice);
  py::array_t<float> nodes(shape);
  float* const data = nodes.mutable_data();
  const py::gil_scoped_release no_gil;
  const Surface surface = extract_surface(state, threads);
  if (surface.triangles.empty()) throw Failure("there is no material left");
  const DistanceTree tree(surface);
  if (!tree.good()) throw Failure("there is not enough memory for the distances");
  const Lattice& lattice = state.lattice;
  size_t i = 0;
  for (int x = 0; x < lattice.nodes.x(); x++)
    for (int y = 0; y < lattice.nodes.y(); y++)
      for (int z = 0; z < lattice.nodes.z(); z++)
        data[i++] = static_cast<float>(
            tree.distance(lattice.to_mm(LatticePoint{Vec3(x + 0.5, y + 0.5, z + 0.5)})));
  for_inside(state, [&](size_t at) { data[at] = -data[at]; });
  return nodes;
}

// Rows from the lowest y, in mm; NaN where there is nothing.
py::array_t<float> heights(const kibori::Snapshot& state) {
  const Index3& nodes = state.lattice.nodes;
  py::array_t<float> map(
      {static_cast<py::ssize_t>(nodes.x()), static_cast<py::ssize_t>(nodes.y())});
  float* const data = map.mutable_data();
  const py::gil_scoped_release no_gil;
  for (int x = 0; x < nodes.x(); x++)
    for (int y = 0; y < nodes.y(); y++) {
      float top = std::numeric_limits<float>::quiet_NaN();
      state.field(Axis::z).for_spans(x, y, [&](const Span& span) {
        top = static_cast<float>(state.lattice.origin_mm.z() +
                                 state.lattice.pitch_mm * double{span.out});
      });
      data[static_cast<size_t>(x) * static_cast<size_t>(nodes.y()) + static_cast<size_t>(y)] = top;
    }
  return map;
}

Image draw(Workpiece& piece, int width, int height, const std::variant<std::string, Three>& view,
           int samples, int threads) {
  PictureOptions options;
  options.width = width;
  options.height = height;
  if (samples < 1 || samples > 65536) throw Failure("samples are 1 to 65536 paths a pixel");
  options.samples = samples;
  options.threads = threads;
  if (const auto* const name = std::get_if<std::string>(&view)) {
    const auto known = view_named(*name);
    if (!known)
      throw Failure("there is no view '" + sanitize_message(*name) +
                    "'; there are iso, front, back, left, right, top, bottom, or a direction");
    options.view = *known;
  } else {
    options.view = vec(std::get<Three>(view));
  }
  const Lattice& lattice = piece.model().lattice();
  options.plank = lattice.to_mm(lattice.whole());
  std::vector<Rgb> colors;
  for (const Material& material : piece.materials()) {
    colors.push_back(material.color);
    // Rings are seen where they are felt.
    options.contrasts.push_back(has_grain(material) ? ring_contrast(material.name) : 0);
  }
  return value_of(draw_picture(surface_of(piece.bench().bodies().all, threads), colors, options));
}

std::string repr(Workpiece& piece) {
  const Lattice& lattice = piece.model().lattice();
  char text[200];
  std::snprintf(text, sizeof text, "<kibori.Model of %d x %d x %d nodes, pitch %g mm, %.6g mm3>",
                lattice.nodes.x(), lattice.nodes.y(), lattice.nodes.z(), lattice.pitch_mm,
                piece.model().volume_mm3());
  return text;
}

// ---- Bodies

struct BodyView {
  BodyId id;
  std::string name;
  bool visible, locked, no_go;
  double volume_mm3;
  std::array<double, 7> pose;
};

std::vector<BodyView> bodies_of(Workpiece& piece) {
  std::vector<BodyView> list;
  for (const Body& body : piece.bench().bodies().all)
    list.push_back({body.id, body.name, body.visible, body.locked, body.no_go,
                    body.model.volume_mm3(), seven(body.pose)});
  return list;
}

std::vector<BodyId> act(Model& model, const BodyAction& action) {
  return model.with([&](Workpiece& piece) { return value_of(piece.act(action)).made; });
}

BodyAction with_bodies(BodyVerb verb, std::vector<BodyId> bodies) {
  BodyAction action;
  action.verb = verb;
  action.bodies = std::move(bodies);
  return action;
}

void bind_carving(py::class_<Model, Shared>& model) {
  const char* const about =
      "carve(tool, path, mode='cut', ...) -> Carved\n\n"
      "Moves a tool along a path, exactly from each pose to the next, as one stroke.\n\n"
      "path: array [N, 3] of tips, or [N, 7] of poses (x, y, z, and a quaternion x, y, z, w that "
      "turns the upright tool), mm. N rows give N - 1 sweeps.\n"
      "mode: cut, deposit, touch, off, or one that reshapes (smooth, rasp, fill, inflate, flatten, "
      "crease, paint, grab, nudge, twist, bend, pinch, scale, node, press, throw, turn).\n"
      "material: name or Material that a deposit puts down.\n"
      "force: energy (-u dV/|p|), paper (-Kf K) or series (the path is a hand's, and the tool "
      "hangs "
      "on its spring); dof: 5 or 6; rate: ticks a second; powered: '', 'motor' or 'press'.\n"
      "mirror: planes, letters of 'xyz'; fold, axis: turns about an axis; centre: a point of both "
      "[mm], the lattice's middle unless given.\n"
      "crumbs: what becomes of what is severed: stay, sort, fall, body.\n"
      "brush: dict of radius, strength, falloff, sigma, ... for modes that reshape [mm].\n\n"
      "Errors (kibori.Error, ValueError) leave the model as it was. Other Python threads run "
      "meanwhile.";
  model.def(
      "carve",
      [](const Shared& self, const Tool& tool, const Doubles& path, const std::string& mode,
         const std::optional<MaterialOrName>& material, const std::string& force, int dof,
         double rate, const std::string& powered, const std::string& mirror, int fold,
         const std::string& axis, const std::optional<Three>& centre, const std::string& crumbs,
         const py::dict& brush, const std::string& label) {
        const std::vector<Pose> poses = poses_of(path);
        const StrokeChoice choice = choice_of(tool, mode, material, force, dof, rate, powered,
                                              mirror, fold, axis, centre, crumbs, brush, label);
        return carve(*self, choice, poses);
      },
      py::arg("tool"), py::arg("path"), py::arg("mode") = "cut", py::arg("material") = py::none(),
      py::kw_only(), py::arg("force") = "energy", py::arg("dof") = 5, py::arg("rate") = 1000.0,
      py::arg("powered") = "", py::arg("mirror") = "", py::arg("fold") = 1, py::arg("axis") = "z",
      py::arg("centre") = py::none(), py::arg("crumbs") = "stay", py::arg("brush") = py::dict(),
      py::arg("label") = "", about);
  model.def(
      "stroke",
      [](const Shared& self, const Tool& tool, const Doubles& start, const std::string& mode,
         const std::optional<MaterialOrName>& material, const std::string& force, int dof,
         double rate, const std::string& powered, const std::string& mirror, int fold,
         const std::string& axis, const std::optional<Three>& centre, const std::string& crumbs,
         const py::dict& brush, const std::string& label) {
        const Pose pose = pose_of(start);
        const StrokeChoice choice = choice_of(tool, mode, material, force, dof, rate, powered,
                                              mirror, fold, axis, centre, crumbs, brush, label);
        return std::make_unique<Stroke>(self, choice, pose);
      },
      py::arg("tool"), py::arg("start"), py::arg("mode") = "cut", py::arg("material") = py::none(),
      py::kw_only(), py::arg("force") = "energy", py::arg("dof") = 5, py::arg("rate") = 1000.0,
      py::arg("powered") = "", py::arg("mirror") = "", py::arg("fold") = 1, py::arg("axis") = "z",
      py::arg("centre") = py::none(), py::arg("crumbs") = "stay", py::arg("brush") = py::dict(),
      py::arg("label") = "",
      "stroke(tool, start, ...) -> Stroke\n\nThe same, led pose by pose: with m.stroke(tool, "
      "start) "
      "as s: tick = s.move(pose).");
}

void bind_looking(py::class_<Model, Shared>& model) {
  model
      .def_property_readonly(
          "volume_mm3",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.model().volume_mm3(); });
          },
          "Volume of the active body [mm^3]: the mean of the three fields.")
      .def_property_readonly(
          "hash",
          [](Model& self) {
            return self.with(
                [](Workpiece& piece) { return piece.bench().bodies().content_hash(); });
          },
          "Of the whole content of all bodies; equal models have equal hashes.")
      .def_property_readonly(
          "pitch",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.model().lattice().pitch_mm; });
          },
          "Between two rays [mm].")
      .def_property_readonly(
          "nodes",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return shape_of(piece.model().lattice()); });
          },
          "Lattice nodes along x, y and z.")
      .def_property_readonly(
          "origin",
          [](Model& self) {
            return self.with(
                [](Workpiece& piece) { return three(piece.model().lattice().origin_mm); });
          },
          "Lower corner of the lattice [mm]; node i stands at origin + (i + 1/2) pitch.")
      .def_property_readonly(
          "materials",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.materials(); }); },
          "What the model is of; surfaces and deposits number these.")
      .def_property_readonly(
          "mass_g",
          [](Model& self) {
            return self.with([](Workpiece& piece) {
              std::vector<double> density;
              for (const Material& m : piece.materials()) density.push_back(density_of(m.name));
              return mass_of(piece.model().snapshot(), density).mass_g;
            });
          },
          "Mass of the active body [g]; 0 where a material's density is not known.")
      .def(
          "snapshot",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return State{piece.model().snapshot()}; });
          },
          "The active body as it is now; it does not change, and may be read by any thread.")
      .def(
          "surface",
          [](Model& self, int threads) {
            const auto state = self.with([](Workpiece& piece) { return piece.model().snapshot(); });
            return surface_of_state(state, threads);
          },
          py::arg("threads") = 1, "The active body's Surface: closed and manifold.")
      .def(
          "occupancy",
          [](Model& self) {
            return occupancy(self.with([](Workpiece& piece) { return piece.model().snapshot(); }));
          },
          "Array [nodes x, y, z] of bool: which lattice nodes are inside.")
      .def(
          "signed_distance",
          [](Model& self, int threads) {
            return signed_distance(
                self.with([](Workpiece& piece) { return piece.model().snapshot(); }), threads);
          },
          py::arg("threads") = 1,
          "Array [nodes x, y, z] of float32: from each lattice node to the surface [mm], negative "
          "inside.")
      .def(
          "height_map",
          [](Model& self) {
            return heights(self.with([](Workpiece& piece) { return piece.model().snapshot(); }));
          },
          "Array [nodes x, y] of float32: how high the model is [mm], seen from above; NaN where "
          "there is nothing.")
      .def(
          "picture",
          [](Model& self, int width, int height, const std::variant<std::string, Three>& view,
             int samples, int threads) {
            Image image = self.with([&](Workpiece& piece) {
              return draw(piece, width, height, view, samples, threads);
            });
            py::array_t<uint8_t> pixels(
                {py::ssize_t{image.height}, py::ssize_t{image.width}, py::ssize_t{3}});
            std::copy_n(image.pixels.data()->data(), 3 * image.pixels.size(),
                        pixels.mutable_data());
            return pixels;
          },
          py::arg("width") = 640, py::arg("height") = 480, py::arg("view") = "iso",
          py::arg("samples") = 32, py::arg("threads") = 1,
          "Array [height, width, 3] of uint8: all bodies, ray traced. view: iso, front, back, "
          "left, "
          "right, top, bottom, or the direction to look in.")
      .def(
          "png",
          [](Model& self, int width, int height, const std::variant<std::string, Three>& view,
             int samples, int threads) {
            const std::vector<uint8_t> png = self.with([&](Workpiece& piece) {
              const Image image = draw(piece, width, height, view, samples, threads);
              return value_of(png_rgb(image.width, image.height, image.pixels));
            });
            return py::bytes(reinterpret_cast<const char*>(png.data()), png.size());
          },
          py::arg("width") = 640, py::arg("height") = 480, py::arg("view") = "iso",
          py::arg("samples") = 32, py::arg("threads") = 1, "The same as the bytes of a PNG file.")
      .def("__repr__", [](Model& self) { return self.with(repr); });
}

void bind_history(py::class_<Model, Shared>& model) {
  model
      .def(
          "undo", [](Model& self) { self.with([](Workpiece& piece) { must(piece.undo()); }); },
          "Takes the last step back.")
      .def(
          "redo", [](Model& self) { self.with([](Workpiece& piece) { must(piece.redo()); }); },
          "Does the last step that was taken back again.")
      .def_property_readonly(
          "steps",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.done(); }); },
          "Steps that are done since the model was made or opened.")
      .def(
          "save",
          [](Model& self, const std::filesystem::path& path, bool overwrite) {
            self.with([&](Workpiece& piece) { must(piece.save(path, overwrite)); });
          },
          py::arg("path"), py::arg("overwrite") = false,
          "Writes a .kibori document: the stock, and every step that is done. The studio and "
          "kibori "
          "replay read it.")
      .def(
          "export",
          [](Model& self, const std::filesystem::path& path, double tolerance, int threads) {
            return self.with([&](Workpiece& piece) {
              std::vector<Rgb> colors;
              for (const Material& m : piece.materials()) colors.push_back(m.color);
              return value_of(
                  write_bodies(path, piece.bench().bodies().all, colors, tolerance, threads));
            });
          },
          py::arg("path"), py::arg("tolerance") = 0.0, py::arg("threads") = 1,
          "Writes the surface (.stl, .ply, .obj, .3mf, .glb), closed and manifold [mm]; tolerance "
          "[mm]: fewer triangles, as long as it stays so near. The number of triangles.");
}

void bind_bodies(py::class_<Model, Shared>& model) {
  using Ids = std::vector<BodyId>;
  model
      .def_property_readonly(
          "bodies", [](Model& self) { return self.with(bodies_of); },
          "All bodies, as they are now.")
      .def_property_readonly(
          "active",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.bench().active(); });
          },
          "Number of the body that strokes work on.")
      .def(
          "activate",
          [](Model& self, BodyId id) {
            self.with([&](Workpiece& piece) { must(piece.bench().activate(id)); });
          },
          py::arg("id"), "Strokes work on that body from now on.")
      .def(
          "split",
          [](Model& self, const Three& point, const Three& normal, double kerf, const Ids& bodies) {
            BodyAction action = with_bodies(BodyVerb::cut, bodies);
            action.cutter.point_mm = vec(point);
            action.cutter.normal = vec(normal);
            action.cutter.kerf_mm = kerf;
            return act(self, action);
          },
          py::arg("point"), py::arg("normal"), py::arg("kerf") = 0.0, py::arg("bodies") = Ids(),
          "Cuts by a plane; what lies where normal points becomes bodies of its own, whose numbers "
          "these are. kerf [mm]: what a saw would take. bodies: which; none: all.")
      .def(
          "separate",
          [](Model& self, BodyId id) { return act(self, with_bodies(BodyVerb::separate, {id})); },
          py::arg("id"), "Each piece becomes a body; the largest stays. The new ones' numbers.")
      .def(
          "join", [](Model& self, const Ids& ids) { act(self, with_bodies(BodyVerb::join, ids)); },
          py::arg("ids"), "The others go into the first.")
      .def(
          "subtract",
          [](Model& self, const Ids& ids) { act(self, with_bodies(BodyVerb::subtract, ids)); },
          py::arg("ids"), "The others are cut from the first, and stay.")
      .def(
          "intersect",
          [](Model& self, const Ids& ids) { act(self, with_bodies(BodyVerb::intersect, ids)); },
          py::arg("ids"), "Of the first stays what lies in all others, which stay.")
      .def(
          "duplicate",
          [](Model& self, BodyId id) { return act(self, with_bodies(BodyVerb::duplicate, {id})); },
          py::arg("id"), "A copy in the same place; its number.")
      .def(
          "place",
          [](Model& self, BodyId id, const Doubles& pose) {
            BodyAction action = with_bodies(BodyVerb::move, {id});
            action.pose = pose_of(pose);
            act(self, action);
          },
          py::arg("id"), py::arg("pose"),
          "Puts a body's lattice there: x, y, z, or x, y, z and a quaternion x, y, z, w [mm].")
      .def(
          "remove", [](Model& self, BodyId id) { act(self, with_bodies(BodyVerb::remove, {id})); },
          py::arg("id"))
      .def(
          "set_no_go",
          [](Model& self, BodyId id, bool no_go) {
            BodyAction action = with_bodies(BodyVerb::set, {id});
            action.no_go = no_go;
            act(self, action);
          },
          py::arg("id"), py::arg("no_go") = true,
          "No stroke on another body cuts into what it holds.");
}

void bind_values(py::module_& module) {
  py::class_<Material>(
      module, "Material",
      "Material(name, u, kf=..., u_along=0, ring=0, ...): what is carved. u: "
      "specific cutting energy [N/mm^2]; kf [N a point], of the force model paper.")
      .def(py::init([](const std::string& name, double u, double kf, double c, double yield_n,
                       const std::array<uint8_t, 3>& color, bool plastic, double gc, double u_along,
                       double ring) {
             for (const double number : {u, kf, c, yield_n, gc, u_along, ring})
               if (!(number >= 0) || !(number < 1e9))
                 throw Failure("a material's numbers are 0 or more");
             if (ring > kMaxRing) throw Failure("ring is at most 5");
             return Material{name, kf, u, c, yield_n, color, plastic, gc, u_along, ring};
           }),
           py::arg("name"), py::arg("u"), py::kw_only(), py::arg("kf") = 0.001, py::arg("c") = 0.0,
           py::arg("yield_n") = 0.0, py::arg("color") = std::array<uint8_t, 3>{196, 154, 108},
           py::arg("plastic") = false, py::arg("gc") = 0.3, py::arg("u_along") = 0.0,
           py::arg("ring") = 0.0)
      .def_readonly("name", &Material::name)
      .def_readonly("u", &Material::u)
      .def_readonly("kf", &Material::kf)
      .def_readonly("c", &Material::c)
      .def_readonly("yield_n", &Material::yield_n)
      .def_readonly("color", &Material::color)
      .def_readonly("plastic", &Material::plastic)
      .def_readonly("gc", &Material::gc)
      .def_readonly("u_along", &Material::u_along)
      .def_readonly("ring", &Material::ring)
      .def("__repr__",
           [](const Material& material) { return "<kibori.Material " + material.name + ">"; });
  module.def(
      "known_materials", [] { return known_materials(); }, "Those that are known by name.");
  py::class_<Carved>(module, "Carved", "What a path came to, sweep by sweep.")
      .def_readonly("removed_mm3", &Carved::removed_mm3,
                    "[N-1] mm^3, the mean of the three fields; negative where material was added.")
      .def_readonly("points", &Carved::points, "[N-1] lattice nodes that were removed or added.")
      .def_readonly("force", &Carved::force, "[N-1, 3] N, on the tool (series: on the hand).")
      .def_readonly("moment", &Carved::moment, "[N-1, 3] N mm, about the tip.")
      .def_readonly("poses", &Carved::poses,
                    "[N-1, 7] of the tool at each end: x, y, z [mm] and a quaternion x, y, z, w.")
      .def_readonly("fallen_mm3", &Carved::fallen_mm3, "What was severed and fell away.")
      .def_readonly("severed", &Carved::severed, "Numbers of the bodies that were severed.")
      .def("__len__", [](const Carved& carved) { return carved.removed_mm3.size(); });
  py::class_<SurfaceArrays>(module, "Surface",
                            "A surface as arrays, which are views of memory that stays as long as "
                            "one of them does, whatever becomes of the model.")
      .def_readonly("vertices", &SurfaceArrays::vertices, "[N, 3] float32, mm.")
      .def_readonly("normals", &SurfaceArrays::normals, "[N, 3] float32, out of the material.")
      .def_readonly("triangles", &SurfaceArrays::triangles,
                    "[M, 3] uint32, counterclockwise seen from outside.")
      .def_readonly("materials", &SurfaceArrays::materials, "[N] uint8: see Model.materials.")
      .def_readonly("paint", &SurfaceArrays::paint, "[N] uint32, 0xAABBGGRR; 0: unpainted.");
  py::class_<Felt>(module, "Tick", "What one move of a stroke came to.")
      .def_readonly("removed_mm3", &Felt::removed_mm3)
      .def_readonly("points", &Felt::points)
      .def_readonly("force", &Felt::force, "N, on the tool (series: on the hand).")
      .def_readonly("moment", &Felt::moment, "N mm, about the tip.")
      .def_readonly("pose", &Felt::pose, "x, y, z [mm] and a quaternion x, y, z, w.");
  py::class_<Stroke>(module, "Stroke", "A stroke that is led pose by pose: see Model.stroke.")
      .def(
          "move", [](Stroke& self, const Doubles& pose) { return self.move(pose_of(pose)); },
          py::arg("pose"), "Moves the tool there, x, y, z or x, y, z and a quaternion; a Tick.")
      .def("end", &Stroke::end, "It is one step of the history from now on.")
      .def("cancel", &Stroke::cancel, "It is as if it had not been.")
      .def("__enter__", [](py::object self) { return self; })
      .def("__exit__",
           [](Stroke& self, const py::object& type, const py::object&, const py::object&) {
             if (type.is_none())
               self.end();
             else
               self.cancel();
           });
  py::class_<State>(module, "Snapshot", "A body as it was at one moment; outlives its model.")
      .def_property_readonly("volume_mm3",
                             [](const State& self) {
                               const py::gil_scoped_release no_gil;
                               return self.snapshot.volume_mm3();
                             })
      .def_property_readonly("hash",
                             [](const State& self) {
                               const py::gil_scoped_release no_gil;
                               return self.snapshot.content_hash();
                             })
      .def(
          "surface",
          [](const State& self, int threads) { return surface_of_state(self.snapshot, threads); },
          py::arg("threads") = 1)
      .def("occupancy", [](const State& self) { return occupancy(self.snapshot); })
      .def(
          "signed_distance",
          [](const State& self, int threads) { return signed_distance(self.snapshot, threads); },
          py::arg("threads") = 1)
      .def("height_map", [](const State& self) { return heights(self.snapshot); });
  py::class_<BodyView>(module, "Body", "A body as it was when Model.bodies was read.")
      .def_readonly("id", &BodyView::id)
      .def_readonly("name", &BodyView::name)
      .def_readonly("visible", &BodyView::visible)
      .def_readonly("locked", &BodyView::locked)
      .def_readonly("no_go", &BodyView::no_go)
      .def_readonly("volume_mm3", &BodyView::volume_mm3)
      .def_readonly("pose", &BodyView::pose)
      .def("__repr__", [](const BodyView& body) {
        return "<kibori.Body " + std::to_string(body.id) + " '" + body.name + "'>";
      });
}

}  // namespace

void bind_model(py::module_& module) {
  bind_values(module);
  const MaterialOrName lime = std::string("limewood");
  py::class_<Model, Shared> model(
      module, "Model",
      "A piece to carve. Made by Model.block, sphere, cylinder, mesh, volume or open. Lengths are "
      "mm. Threads may share it: they take turns.");
  model
      .def_static(
          "block", &block, py::arg("size"), py::arg("pitch"), py::arg("material") = lime,
          py::kw_only(), py::arg("room") = py::none(), py::arg("threads") = 1,
          "A block from the origin to size [mm]; room: space around it [mm], a tenth of its "
          "longest side unless given.")
      .def_static("sphere", &sphere, py::arg("diameter"), py::arg("pitch"),
                  py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
                  py::arg("threads") = 1, "A ball whose bounds begin at the origin.")
      .def_static("cylinder", &cylinder, py::arg("diameter"), py::arg("height"), py::arg("pitch"),
                  py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
                  py::arg("threads") = 1, "Upright; its bounds begin at the origin.")
      .def_static("mesh", &mesh_file, py::arg("path"), py::arg("pitch"), py::arg("material") = lime,
                  py::kw_only(), py::arg("fit") = py::none(), py::arg("room") = py::none(),
                  py::arg("threads") = 1,
                  "A mesh file (.stl, .ply, .obj, .off, .3mf, .glb), in mm; fit: its longest side "
                  "[mm].")
      .def_static(
          "mesh", &mesh_arrays, py::arg("vertices"), py::arg("triangles"), py::arg("pitch"),
          py::arg("material") = lime, py::kw_only(), py::arg("room") = py::none(),
          py::arg("threads") = 1,
          "A mesh of arrays: vertices [N, 3] in mm, triangles [M, 3], counterclockwise seen "
          "from outside.")
      .def_static(
          "volume", &volume, py::arg("labels"), py::arg("voxel"), py::arg("pitch"),
          py::arg("materials") = std::map<uint16_t, MaterialOrName>(), py::kw_only(),
          py::arg("room") = py::none(), py::arg("threads") = 1,
          "Labelled voxels [x, y, z], 0 is air; voxel: their sides [mm]; materials: of each "
          "label.")
      .def_static(
          "open",
          [](const std::filesystem::path& path) {
            const py::gil_scoped_release no_gil;
            return shared(Workpiece::open(path));
          },
          py::arg("path"), "What a .kibori document has at its head; the file stays as it is.");
  bind_carving(model);
  bind_looking(model);
  bind_history(model);
  bind_bodies(model);
}

}  // namespace kibori::python
