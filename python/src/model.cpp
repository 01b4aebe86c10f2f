// SPDX-License-Identifier: MIT
// Model as a whole: its numbers, pictures, history and files.
#include "python/src/model.h"

#include <cmath>
#include <cstdio>

#include <kibori/body/body_surface.h>
#include <kibori/report/convert.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/formats/png_file.h>
#include <kibori/haptics/materials.h>
#include <kibori/measure/mass.h>
#include <kibori/picture/picture.h>

#include "python/src/materials.h"

namespace kibori::python {
namespace {

Image draw(Workpiece& piece, int width, int height, const std::variant<std::string, Three>& view,
           int samples, int threads) {
  PictureOptions options;
  options.width = width;
  options.height = height;
  if (samples < 1 || samples > 65536) throw Failure("samples must be 1 to 65536 paths per pixel");
  options.samples = samples;
  options.threads = threads;
  if (const auto* const name = std::get_if<std::string>(&view)) {
    const auto known = view_named(*name);
    if (!known)
      throw Failure("there is no view '" + sanitize_message(*name) +
                    "'; use iso, front, back, left, right, top, bottom, or a direction");
    options.view = *known;
  } else {
    options.view = vec(std::get<Three>(view));
  }
  const Lattice& lattice = piece.model().lattice();
  options.plank = lattice.to_mm(lattice.base());
  std::vector<Rgb> colors;
  for (const Material& material : piece.materials()) {
    colors.push_back(material.color);
    // Rings are drawn only for materials with a grain.
    options.contrasts.push_back(has_grain(material) ? ring_contrast(material.name) : 0);
  }
  options.log = log_cut_of(piece.materials());
  return value_of(draw_picture(surface_of(piece.bodies().all, threads), colors, options));
}

std::string repr(Workpiece& piece) {
  const Lattice& lattice = piece.model().lattice();
  const Index3 nodes = lattice.high() - lattice.low();
  char text[200];
  std::snprintf(text, sizeof text, "<kibori.Model of %d x %d x %d nodes, pitch %g mm, %.6g mm3>",
                nodes.x(), nodes.y(), nodes.z(), lattice.pitch_mm, piece.model().volume_mm3());
  return text;
}

void bind_looking(ModelClass& model) {
  model
      .def_property_readonly(
          "volume_mm3",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.model().volume_mm3(); });
          },
          "Volume of the active body [mm^3]. It does not depend on the position on the lattice.")
      .def_property_readonly(
          "hash",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.bodies().content_hash(); });
          },
          "Hash of the content of all bodies. Equal models have equal hashes.")
      .def_property_readonly(
          "pitch",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return piece.model().lattice().pitch_mm; });
          },
          "Distance between neighbouring rays [mm].")
      .def_property_readonly(
          "nodes",
          [](Model& self) {
            return self.with([](Workpiece& piece) { return shape_of(piece.model().lattice()); });
          },
          "Number of lattice nodes along x, y and z.")
      .def_property(
          "grows",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.grows(); }); },
          [](Model& self, bool grows) {
            self.with([grows](Workpiece& piece) { piece.set_grows(grows); });
          },
          "True (the default) if the lattice grows when a stroke needs room. Otherwise strokes are "
          "cut off at its border.")
      .def_property_readonly(
          "origin",
          [](Model& self) {
            return self.with([](Workpiece& piece) {
              const Lattice& lattice = piece.model().lattice();
              return three(lattice.to_mm(lattice.whole()).min);
            });
          },
          "Lower corner of the lattice [mm]; node i is at origin + (i + 1/2) pitch. It moves when "
          "the lattice grows.")
      .def_property_readonly(
          "materials",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.materials(); }); },
          "Materials of the model. Surfaces contain indices of this list.")
      .def_property_readonly(
          "mass_g",
          [](Model& self) {
            return self.with([](Workpiece& piece) -> std::optional<double> {
              std::vector<double> density;
              for (const Material& m : piece.materials()) density.push_back(m.density_kg_m3);
              const double mass = mass_of(piece.model().snapshot(), density).mass_g;
              if (mass > 0) return mass;
              return std::nullopt;
            });
          },
          "Mass of the active body [g]; None if the density of one of its materials is unknown.")
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
          "right, top, bottom, or a viewing direction.")
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
          py::arg("samples") = 32, py::arg("threads") = 1,
          "The same picture as the bytes of a PNG file.")
      .def("__repr__", [](Model& self) { return self.with(repr); });
}

void bind_history(ModelClass& model) {
  model
      .def(
          "undo", [](Model& self) { self.with([](Workpiece& piece) { must(piece.undo()); }); },
          "Undoes the last step.")
      .def(
          "redo", [](Model& self) { self.with([](Workpiece& piece) { must(piece.redo()); }); },
          "Repeats the step that was undone last.")
      .def_property_readonly(
          "steps",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.done(); }); },
          "Number of steps since the model was made or opened, without undone steps.")
      .def(
          "save",
          [](Model& self, const std::filesystem::path& path, bool overwrite) {
            self.with([&](Workpiece& piece) { must(piece.save(path, overwrite)); });
          },
          py::arg("path"), py::arg("overwrite") = false,
          "Writes a .kibori document: the stock, and every step that is not undone. The studio and "
          "kibori replay read it.")
      .def(
          "export",
          [](Model& self, const std::filesystem::path& path, double tolerance, int threads) {
            if (!(tolerance >= 0) || !std::isfinite(tolerance))
              throw Failure("tolerance must be 0 mm or more");
            return self.with([&](Workpiece& piece) {
              std::vector<Rgb> colors;
              for (const Material& m : piece.materials()) colors.push_back(m.color);
              return value_of(write_bodies(path, piece.bodies().all, colors, tolerance, threads));
            });
          },
          py::arg("path"), py::arg("tolerance") = 0.0, py::arg("threads") = 1,
          ("Writes the surface in mm (" + list_of(kMeshesWritten) +
           "), closed and manifold. tolerance: max distance [mm] of a surface with fewer "
           "triangles. "
           "Returns the number of triangles.")
              .c_str());
}

}  // namespace

void bind_model(py::module_& module) {
  ModelClass model(
      module, "Model",
      "A piece to carve. Made by Model.block, sphere, cylinder, mesh, volume or open. Lengths are "
      "mm. Threads may share it; calls run one at a time.");
  bind_stocks(model);
  bind_strokes(module, model);
  bind_arrays(module, model);
  bind_bodies(module, model);
  bind_looking(model);
  bind_history(model);
}

}  // namespace kibori::python
