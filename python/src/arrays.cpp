// SPDX-License-Identifier: MIT
// The data of a model as arrays: surfaces, nodes, distances, heights.
#include <algorithm>
#include <cmath>
#include <limits>

#include <kibori/measure/distance.h>
#include <kibori/surface/surface.h>

#include "python/src/model.h"

namespace kibori::python {

std::array<py::ssize_t, 3> shape_of(const Lattice& lattice) {
  const Index3 nodes = lattice.high() - lattice.low();
  return {nodes.x(), nodes.y(), nodes.z()};
}

namespace {

// A state of the active body. It does not change, and it may outlive its model.
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

// Calls f(i) for every lattice node inside the material, with its index in an array [x, y, z].
template <class F>
void for_inside(const kibori::Snapshot& state, F&& f) {
  const Index3 low = state.lattice.low(), nodes = state.lattice.high() - low;
  const FieldSnapshot& z = state.field(Axis::z);
  for (int x = 0; x < nodes.x(); x++)
    for (int y = 0; y < nodes.y(); y++)
      z.for_spans(low.x() + x, low.y() + y, [&](const Span& span) {
        // Nodes are at k + 1/2.
        const double in = double{span.in} - low.z(), out = double{span.out} - low.z();
        const int first = std::max(0, static_cast<int>(std::ceil(in - 0.5)));
        for (int k = first; k < nodes.z() && k + 0.5 < out; k++)
          f((static_cast<size_t>(x) * static_cast<size_t>(nodes.y()) + static_cast<size_t>(y)) *
                static_cast<size_t>(nodes.z()) +
            static_cast<size_t>(k));
      });
}

size_t node_count(const Lattice& lattice) {
  return static_cast<size_t>((lattice.high() - lattice.low()).cast<int64_t>().prod());
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
  if (!tree.good()) throw Failure("not enough memory for the distances");
  const Lattice& lattice = state.lattice;
  size_t i = 0;
  const Index3 low = lattice.low(), high = lattice.high();
  for (int x = low.x(); x < high.x(); x++)
    for (int y = low.y(); y < high.y(); y++)
      for (int z = low.z(); z < high.z(); z++)
        data[i++] = static_cast<float>(
            tree.distance(lattice.to_mm(LatticePoint{Vec3(x + 0.5, y + 0.5, z + 0.5)})));
  for_inside(state, [&](size_t at) { data[at] = -data[at]; });
  return nodes;
}

// The top of the material above each [x, y], in mm. NaN where there is no material.
py::array_t<float> heights(const kibori::Snapshot& state) {
  const Index3 low = state.lattice.low(), nodes = state.lattice.high() - low;
  py::array_t<float> map(
      {static_cast<py::ssize_t>(nodes.x()), static_cast<py::ssize_t>(nodes.y())});
  float* const data = map.mutable_data();
  const py::gil_scoped_release no_gil;
  for (int x = 0; x < nodes.x(); x++)
    for (int y = 0; y < nodes.y(); y++) {
      float top = std::numeric_limits<float>::quiet_NaN();
      state.field(Axis::z).for_spans(low.x() + x, low.y() + y, [&](const Span& span) {
        top = static_cast<float>(state.lattice.origin_mm.z() +
                                 state.lattice.pitch_mm * double{span.out});
      });
      data[static_cast<size_t>(x) * static_cast<size_t>(nodes.y()) + static_cast<size_t>(y)] = top;
    }
  return map;
}

}  // namespace

py::object surface_arrays(const kibori::Snapshot& snapshot, int threads) {
  return py::cast(surface_of_state(snapshot, threads));
}

void bind_arrays(py::module_& module, ModelClass& model) {
  py::class_<SurfaceArrays>(module, "Surface",
                            "A surface as arrays. Later changes of the model do not affect them.")
      .def_readonly("vertices", &SurfaceArrays::vertices, "[N, 3] float32, mm.")
      .def_readonly("normals", &SurfaceArrays::normals,
                    "[N, 3] float32, pointing out of the material.")
      .def_readonly("triangles", &SurfaceArrays::triangles,
                    "[M, 3] uint32, counterclockwise seen from outside.")
      .def_readonly("materials", &SurfaceArrays::materials, "[N] uint8: see Model.materials.")
      .def_readonly("paint", &SurfaceArrays::paint,
                    "[N] uint32, 0xMMBBGGRR. MM is 255 - m if painted, else m, with the mask m "
                    "from 0 to 127.");
  py::class_<State>(module, "Snapshot",
                    "The state of a body at one moment. It does not depend on the model.")
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
  model
      .def(
          "snapshot",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return State{piece.model().snapshot()}; });
          },
          "The current state of the active body. It does not change. Any thread may read it.")
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
          "Array [nodes x, y, z] of bool: True for lattice nodes inside.")
      .def(
          "signed_distance",
          [](Model& self, int threads) {
            return signed_distance(
                self.with([](Workpiece& piece) { return piece.model().snapshot(); }), threads);
          },
          py::arg("threads") = 1,
          "Array [nodes x, y, z] of float32: distance from each lattice node to the surface [mm], "
          "negative inside.")
      .def(
          "height_map",
          [](Model& self) {
            return heights(self.with([](Workpiece& piece) { return piece.model().snapshot(); }));
          },
          "Array [nodes x, y] of float32: height of the model seen from above [mm]; NaN if there "
          "is no material.");
}

}  // namespace kibori::python
