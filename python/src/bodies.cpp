// SPDX-License-Identifier: MIT
// The bodies of a model, and the actions on them.
#include <kibori/report/tick_row.h>

#include "python/src/model.h"

namespace kibori::python {
namespace {

struct BodyView {
  BodyId id;
  std::string name;
  bool visible, locked, no_go;
  double volume_mm3;
  std::array<double, 7> pose;
};

std::vector<BodyView> bodies_of(Workpiece& piece) {
  std::vector<BodyView> list;
  for (const Body& body : piece.bodies().all)
    list.push_back({body.id, body.name, body.visible, body.locked, body.no_go,
                    body.model.volume_mm3(), numbers_of(body.pose)});
  return list;
}

std::vector<BodyId> act(Model& model, const BodyAction& action) {
  return model.with([&](Workpiece& piece) { return value_of(piece.act(action)).made; });
}

using Ids = std::vector<BodyId>;

void bind_body_view(py::module_& module) {
  py::class_<BodyView>(module, "Body", "The state of a body when Model.bodies was read.")
      .def_readonly("id", &BodyView::id, "Its number, which never changes.")
      .def_readonly("name", &BodyView::name)
      .def_readonly("visible", &BodyView::visible, "True if pictures show it.")
      .def_readonly("locked", &BodyView::locked, "True if nothing may change it.")
      .def_readonly("no_go", &BodyView::no_go,
                    "True if it is a protected region: no stroke on another body cuts into it.")
      .def_readonly("volume_mm3", &BodyView::volume_mm3, "mm^3.")
      .def_readonly(
          "pose", &BodyView::pose,
          "Pose of its coordinates in the world: x, y, z [mm] and a quaternion x, y, z, w.")
      .def("__repr__", [](const BodyView& body) {
        return "<kibori.Body " + std::to_string(body.id) + " '" + body.name + "'>";
      });
}

void bind_list(ModelClass& model) {
  model
      .def_property_readonly(
          "bodies", [](Model& self) { return self.with(bodies_of); },
          "The current state of all bodies.")
      .def_property_readonly(
          "active",
          [](Model& self) { return self.with([](Workpiece& piece) { return piece.active(); }); },
          "Number of the active body, which strokes change.")
      .def(
          "activate",
          [](Model& self, BodyId id) {
            self.with([&](Workpiece& piece) { must(piece.activate(id)); });
          },
          py::arg("id"), "Makes a body the active one, which strokes change.");
}

void bind_parting(ModelClass& model) {
  model
      .def(
          "split",
          [](Model& self, const Three& point, const Three& normal, double kerf, const Ids& bodies) {
            return act(self, {bodies, BodyCut{{CutPlane{vec(point), vec(normal)}, kerf}}});
          },
          py::arg("point"), py::arg("normal"), py::arg("kerf") = 0.0, py::arg("bodies") = Ids(),
          "Cuts bodies by a plane. The parts on the side of the normal become new bodies. Returns "
          "their numbers. kerf: width of the saw cut [mm]. bodies: numbers of the bodies to cut; "
          "empty: all.")
      .def(
          "separate",
          [](Model& self, BodyId id) {
            return act(self, {{id}, BodySeparate{}});
          },
          py::arg("id"),
          "Makes a body of each separate piece except the largest. Returns the numbers of the new "
          "bodies.");
}

void bind_combining(ModelClass& model) {
  model
      .def(
          "join",
          [](Model& self, const Ids& ids) {
            act(self, {ids, BodyJoin{}});
          },
          py::arg("ids"), "Joins the other bodies with the first, and removes them.")
      .def(
          "subtract",
          [](Model& self, const Ids& ids) {
            act(self, {ids, BodySubtract{}});
          },
          py::arg("ids"), "Cuts the other bodies from the first. The others do not change.")
      .def(
          "intersect",
          [](Model& self, const Ids& ids) {
            act(self, {ids, BodyIntersect{}});
          },
          py::arg("ids"),
          "Keeps the part of the first body that is inside all others. The others do not change.");
}

void bind_placing(ModelClass& model) {
  model
      .def(
          "duplicate",
          [](Model& self, BodyId id) {
            return act(self, {{id}, BodyDuplicate{}});
          },
          py::arg("id"), "Makes a copy in the same place. Returns its number in a list.")
      .def(
          "place",
          [](Model& self, BodyId id, const Doubles& pose) {
            act(self, {{id}, BodyMove{pose_of(pose)}});
          },
          py::arg("id"), py::arg("pose"),
          "Sets the pose of a body: x, y, z, or x, y, z and a quaternion x, y, z, w [mm].")
      .def(
          "remove",
          [](Model& self, BodyId id) {
            act(self, {{id}, BodyRemove{}});
          },
          py::arg("id"), "Removes the body. undo() restores it.")
      .def(
          "set_no_go",
          [](Model& self, BodyId id, bool no_go) {
            BodySet set;
            set.properties.no_go = no_go;
            act(self, {{id}, set});
          },
          py::arg("id"), py::arg("no_go") = true,
          "Makes the body a protected region, or not: no stroke on another body cuts into it.");
}

}  // namespace

void bind_bodies(py::module_& module, ModelClass& model) {
  bind_body_view(module);
  bind_list(model);
  bind_parting(model);
  bind_combining(model);
  bind_placing(model);
}

}  // namespace kibori::python
