// SPDX-License-Identifier: MIT
// A Python class for each tool shape, generated from the library's list.
#include "python/src/tools.h"

#include <cctype>

#include <kibori/scene/stamp.h>

#include "python/src/conversions.h"

namespace kibori::python {
namespace {

// The class of the shape "ball" is Ball.
std::string class_name(const char* shape) {
  std::string name = shape;
  name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

template <class Number>
py::object to_python(const Number& number) {
  if constexpr (std::is_same_v<Number, Vec3>)
    return py::cast(three(number));
  else
    return py::float_(number);
}

template <class Number>
void from_python(Number& number, const py::handle& value) {
  if constexpr (std::is_same_v<Number, Vec3>)
    number = vec(given<Three>(value, "a size must be three numbers"));
  else
    number = given<double>(value, "the parameters of a tool must be numbers");
}

// Sets a tool's number by name. Returns false if there is no such number.
template <class Shape>
bool set_number(Shape& tool, const std::string& name, const py::handle& value) {
  bool found = false;
  Shape::for_numbers(tool, [&](const char* known, auto& number) {
    if (name != known) return;
    from_python(number, value);
    found = true;
  });
  return found;
}

template <class Shape>
std::string numbers_of() {
  const Shape standard;
  std::string text;
  Shape::for_numbers(standard, [&](const char* name, const auto& number) {
    if (!text.empty()) text += ", ";
    text += name;
    text += "=";
    text += py::cast<std::string>(py::repr(to_python(number)));
  });
  return text;
}

template <class Shape>
void bind_shape(py::module_& module) {
  const std::string name = class_name(Shape::kShape);
  if constexpr (std::is_same_v<Shape, MeshTool>) {
    py::class_<MeshTool>(
        module, name.c_str(),
        "A closed triangle mesh as a tool, in tool coordinates [mm]: its tip is the "
        "origin.")
        .def(py::init([](const Doubles& vertices, const py::object& triangles) {
               return MeshTool{std::make_shared<TriangleMesh>(mesh_of(vertices, triangles))};
             }),
             py::arg("vertices"), py::arg("triangles"))
        .def("__repr__", [](const MeshTool& tool) {
          return "Mesh(" + std::to_string(tool.mesh->triangles.size()) + " triangles)";
        });
  } else {
    const std::string numbers = numbers_of<Shape>();
    const std::string about =
        name + "(" + numbers + "): " + Shape::kAbout + ". Lengths in mm, angles in degrees.";
    py::class_<Shape> shape(module, name.c_str(), about.c_str());
    shape.def(py::init([name, numbers](const py::args& args, const py::kwargs& named) {
      Shape tool;
      size_t i = 0;
      Shape::for_numbers(tool, [&](const char*, auto& number) {
        if (i < args.size()) from_python(number, args[i]);
        i++;
      });
      if (args.size() > i)
        throw py::type_error(name + " takes at most " + std::to_string(i) + " numbers: " + numbers);
      for (const auto& [key, value] : named)
        if (!set_number(tool, py::cast<std::string>(key), value))
          throw py::type_error(name + " has no '" + py::cast<std::string>(key) + "'; it has " +
                               numbers);
      if (Status fine = check_tool(tool); !fine) throw Failure(fine.error());
      return tool;
    }));
    const Shape standard;
    Shape::for_numbers(standard, [&](const char* number_name, const auto&) {
      const std::string key = number_name;
      shape.def_property(
          number_name,
          [key](const Shape& tool) {
            py::object value;
            Shape::for_numbers(tool, [&](const char* known, const auto& number) {
              if (key == known) value = to_python(number);
            });
            return value;
          },
          [key](Shape& tool, const py::object& value) {
            Shape changed = tool;
            set_number(changed, key, value);
            if (Status fine = check_tool(changed); !fine) throw Failure(fine.error());
            tool = changed;
          });
    });
    shape.def("__repr__", [name](const Shape& tool) {
      std::string text;
      Shape::for_numbers(tool, [&](const char* known, const auto& number) {
        if (!text.empty()) text += ", ";
        text += known;
        text.append("=").append(py::cast<std::string>(py::repr(to_python(number))));
      });
      return name + "(" + text + ")";
    });
    shape.def("__eq__", [](const Shape& a, const Shape& b) { return a == b; });
  }
}

template <class... Shape>
void bind_shapes(py::module_& module, std::type_identity<std::variant<Shape...>>) {
  (bind_shape<Shape>(module), ...);
}

}  // namespace

TriangleMesh mesh_of(const Doubles& vertices, const py::object& given_triangles) {
  if (vertices.ndim() != 2 || vertices.shape(1) != 3)
    throw py::value_error("vertices must be an array of N rows: x, y, z");
  const auto whole = py::array::ensure(given_triangles);
  if (!whole || whole.ndim() != 2 || whole.shape(1) != 3 ||
      (whole.dtype().kind() != 'i' && whole.dtype().kind() != 'u'))
    throw py::value_error("triangles must be an array of N rows of three whole numbers");
  const auto triangles = Indices::ensure(whole);
  if (!triangles)
    throw py::value_error("triangles must be an array of N rows of three whole numbers");
  TriangleMesh mesh;
  const py::ssize_t count = vertices.shape(0);
  for (py::ssize_t i = 0; i < count; i++) {
    const double* const p = vertices.data(i, 0);
    mesh.vertices.emplace_back(p[0], p[1], p[2]);
    if (!mesh.vertices.back().allFinite())
      throw Failure("vertex " + std::to_string(i) + " has a number that is not finite");
  }
  for (py::ssize_t i = 0; i < triangles.shape(0); i++) {
    const int64_t* const t = triangles.data(i, 0);
    for (int k = 0; k < 3; k++)
      if (t[k] < 0 || t[k] >= count)
        throw Failure("triangle " + std::to_string(i) + " refers to a missing vertex");
    mesh.triangles.push_back(
        {static_cast<uint32_t>(t[0]), static_cast<uint32_t>(t[1]), static_cast<uint32_t>(t[2])});
  }
  if (mesh.triangles.empty()) throw Failure("a mesh needs at least one triangle");
  return mesh;
}

void bind_tools(py::module_& module) {
  bind_shapes(module, std::type_identity<Tool>());
  module.def(
      "text_stamp",
      [](const std::string& text, const std::string& font, double height, double depth,
         double pitch) {
        return value_of(text_stamp({text, font, height, depth}, pitch));
      },
      py::arg("text"), py::arg("font") = "DejaVu Sans", py::arg("height") = 10.0,
      py::arg("depth") = 2.0, py::arg("pitch") = 0.25,
      "Letters as a tool that is pressed into the wood. font: a family that fontconfig knows, or a "
      "font file. height: height of a capital H [mm]. depth: their depth [mm]. pitch: pitch of the "
      "model [mm].");
  module.def(
      "picture_stamp",
      [](const std::string& file, double width, double depth, double back, bool invert,
         double pitch) {
        return value_of(picture_stamp(file, {width, depth, back, invert}, pitch));
      },
      py::arg("file"), py::arg("width") = 20.0, py::arg("depth") = 2.0, py::arg("back") = 8.0,
      py::arg("invert") = false, py::arg("pitch") = 0.25,
      "A grey picture (PNG) as a relief that is pressed in. White is depth [mm] deeper than black. "
      "width: width of the picture [mm]. back: thickness of the plate behind it [mm].");
  module.def(
      "mesh_stamp",
      [](const std::filesystem::path& file, double width) {
        return value_of(mesh_stamp(file, width));
      },
      py::arg("file"), py::arg("width") = 0.0,
      "A mesh file as a tool whose tip is its lowest point. width: the longer horizontal side "
      "after scaling [mm]; 0: not scaled.");
}

}  // namespace kibori::python
