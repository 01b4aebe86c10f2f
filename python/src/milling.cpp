// SPDX-License-Identifier: MIT
// kibori.Milling: a machine that executes one command after another.
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include <kibori/report/mill_report.h>
#include <kibori/run/milling_session.h>

#include "python/src/milling.h"

namespace kibori::python {
namespace {

using Six = std::array<double, 6>;
using Section = std::optional<std::array<double, 2>>;

struct Bench {
  MillPlan plan;
  MillSetupModels models;
  std::unique_ptr<MillSession> session;
  MillSetup& setup() { return plan.setups.front(); }
};
using Milling = Guarded<Bench>;

std::unique_ptr<Milling> begin(const MillingArguments& given) {
  auto bench = std::make_unique<Bench>();
  std::vector<std::string> warnings;
  std::unique_ptr<TriDexel> model;
  MillRequest request = request_of(given, model, warnings);
  request.forces = true;
  {
    const py::gil_scoped_release no_gil;
    bench->plan = done(plan_milling(request, std::move(model)));
    check_outputs(bench->plan, given, {}, {});
    bench->plan.warning = nullptr;
    done(make_models(bench->plan));
    bench->models = done(make_setup_models(bench->plan, bench->setup()));
    MillOptions options = bench->setup().options;
    options.progress = [](size_t, int) { check_signals(); };
    bench->session = done(MillSession::begin(*bench->plan.model, std::move(options)));
  }
  warn(warnings);
  return std::make_unique<Milling>(std::move(bench),
                                   "a program is running; call it again afterwards");
}

Six numbers_of(const AxisPosition& at) {
  return {at.xyz_mm.x(),  at.xyz_mm.y(),  at.xyz_mm.z(),
          at.abc_deg.x(), at.abc_deg.y(), at.abc_deg.z()};
}

std::optional<AxisPosition> position_of(const std::optional<Doubles>& at) {
  if (!at) return std::nullopt;
  if (at->ndim() != 1 || (at->shape(0) != 3 && at->shape(0) != 6))
    throw py::value_error("a placement must be x, y, z, or x, y, z, a, b, c (degrees)");
  AxisPosition position;
  for (py::ssize_t i = 0; i < at->shape(0); i++) {
    const double number = at->data(0)[i];
    if (!(std::abs(number) <= kMaxGcodeNumber))
      throw Failure("a placement must have finite numbers up to 1e9");
    (i < 3 ? position.xyz_mm[i] : position.abc_deg[i - 3]) = number;
  }
  return position;
}

// {"G": 1, "X": 10}. A value may be a list, as in {"G": [0, 90]}.
GcodeLine line_of(const py::dict& words) {
  GcodeLine line;
  const auto add = [&](const std::string& letter, const py::handle& value) {
    const auto number =
        given<double>(value, "the word " + sanitize_message(letter) + " must be a number");
    if (!(std::abs(number) <= kMaxGcodeNumber))
      throw Failure("the word " + letter + " must be a finite number up to 1e9");
    line.words.push_back({letter[0], number});
  };
  for (const auto& [key, value] : words) {
    const auto letter = given<std::string>(key, "the words of a command must be named by letters");
    if (letter.size() != 1 || letter[0] < 'A' || letter[0] > 'Z')
      throw Failure("'" + sanitize_message(letter) +
                    "' does not name a word; a word is named by one capital letter");
    if (py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value))
      for (const py::handle& one : value) add(letter, one);
    else
      add(letter, value);
  }
  return line;
}

Six apply(Milling& self, const std::variant<std::string, py::dict>& command,
          const std::optional<Doubles>& at) {
  const std::optional<AxisPosition> from = position_of(at);
  const auto* const text = std::get_if<std::string>(&command);
  std::optional<GcodeLine> line;
  if (!text)
    line = line_of(std::get<py::dict>(command));
  else if (text->find('\n') < text->find_last_not_of("\r\n"))
    throw Failure("apply executes one line; call it for each line, or run() with a file");
  return self.with([&](Bench& bench) {
    MillSession& session = *bench.session;
    done(text ? session.apply(std::string_view(*text).substr(0, text->find_first_of("\r\n")), from)
              : session.apply(*line, from));
    return numbers_of(session.at());
  });
}

void set_tool(Milling& self, const Tool& cutter, int number, const std::string& name, int teeth,
              const Section& neck, const Section& shank, const Section& holder) {
  MillTool tool;
  tool.cutter = cutter;
  tool.number = number;
  tool.name = sanitize_message(name);
  if (teeth < 0 || teeth > 1000) throw Failure("teeth must be 0 (unknown) to 1000");
  tool.teeth = teeth;
  for (const auto& [part, section] :
       {std::pair{BodyPart::neck, &neck}, {BodyPart::shank, &shank}, {BodyPart::holder, &holder}})
    if (*section && !add_section(tool, part, (**section)[0], (**section)[1]))
      throw Failure(std::string(name_of(part)) +
                    " must be (diameter, height of its end above the tip), each above the part "
                    "below");
  self.with([&](Bench& bench) { done(bench.session->set_tool(tool)); });
}

py::list collisions(Milling& self, std::optional<int> line) {
  size_t current = 0;
  const std::vector<MillCollision> all = self.with([&](Bench& bench) {
    current = bench.session->program();
    return bench.session->collisions();
  });
  py::list list;
  for (const MillCollision& c : all) {
    if (line && !(c.line == *line && c.program == current)) continue;
    py::dict one;
    one["kind"] = std::string(name_of(c.kind));
    one["line"] = c.line;
    one["tool"] = c.tool;
    one["time_s"] = c.time_s;
    one["place_mm"] = three(c.place_mm);
    one["volume_mm3"] = c.volume_mm3;
    list.append(one);
  }
  return list;
}

py::object report(Milling& self) {
  return parsed(self.with([](Bench& bench) {
    MillSetup& setup = bench.setup();
    setup.summary = bench.session->summary();
    if (bench.models.target) done(compare_setup(bench.plan, setup, *bench.models.target));
    return mill_json(results_of(bench.plan));
  }));
}

std::array<double, 7> pose_numbers(const Pose& pose) {
  const Eigen::Quaterniond turn(pose.frame);
  return {pose.tip.x(), pose.tip.y(), pose.tip.z(), turn.x(), turn.y(), turn.z(), turn.w()};
}

void bind_class(py::module_& module) {
  const auto snapshot = [](Milling& self) {
    return self.with([](Bench& bench) {
      bench.session->settle();
      return bench.plan.model->snapshot();
    });
  };
  py::class_<Milling>(module, "Milling",
                      "A milling machine that executes one command after another on a stock. "
                      "Threads may share it; calls run one at a time.")
      .def(py::init([](const MillingStock& stock, const std::optional<double>& pitch,
                       const std::optional<Path>& tools, const std::optional<int>& tool,
                       const std::optional<Path>& machine,
                       const std::optional<std::string>& material,
                       const std::vector<Path>& fixtures, const std::optional<Path>& target,
                       const std::optional<double>& tolerance, bool z_only, int threads) {
             return begin({stock, pitch, tolerance, tools, machine, target, tool, material,
                           fixtures, z_only, threads});
           }),
           py::arg("stock"), py::arg("pitch") = py::none(), py::kw_only(),
           py::arg("tools") = py::none(), py::arg("tool") = py::none(),
           py::arg("machine") = py::none(), py::arg("material") = py::none(),
           py::arg("fixtures") = std::vector<Path>(), py::arg("target") = py::none(),
           py::arg("tolerance") = py::none(), py::arg("z_only") = false, py::arg("threads") = 1,
           "stock: a block x0, y0, z0, x1, y1, z1 [mm], a mesh or document file, or a Model, which "
           "does not change. pitch: size of a cell [mm]. The other arguments are those of "
           "kibori.mill.")
      .def("set_tool", &set_tool, py::arg("cutter"), py::arg("number") = 1, py::kw_only(),
           py::arg("name") = "", py::arg("teeth") = 0, py::arg("neck") = py::none(),
           py::arg("shank") = py::none(), py::arg("holder") = py::none(),
           "Puts a tool into the spindle. cutter: a tool shape. teeth: needed for forces. neck, "
           "shank, holder: (diameter, height of its upper end above the tip) [mm].")
      .def("apply", &apply, py::arg("command"), py::arg("at") = py::none(),
           "Executes one command: a line of G-code, or its words as a dict, {\"G\": 1, \"X\": 10}. "
           "at: the placement before it, x, y, z or x, y, z, a, b, c (mm, degrees); default: where "
           "the last command ended. Modes (feed, units, plane, ...) stay. Returns the placement "
           "after it, six numbers.")
      .def(
          "run",
          [](Milling& self, const Path& program) {
            self.with([&](Bench& bench) { done(bench.session->run(program)); });
          },
          py::arg("program"), "Runs a program file from its beginning.")
      .def_property_readonly(
          "at",
          [](Milling& self) {
            return self.with([](Bench& bench) { return numbers_of(bench.session->at()); });
          },
          "Placement of the machine: x, y, z [mm], a, b, c [degrees].")
      .def_property_readonly(
          "pose",
          [](Milling& self) {
            return self.with([](Bench& bench) { return pose_numbers(bench.session->pose()); });
          },
          "Pose of the tool in the part's frame: x, y, z of its tip and a quaternion x, y, z, w. "
          "It includes the rotary axes of the machine.")
      .def_property_readonly(
          "line",
          [](Milling& self) {
            return self.with([](Bench& bench) { return bench.session->line(); });
          },
          "Number of the last command, from 1. run() begins again.")
      .def("collisions", &collisions, py::arg("line") = py::none(),
           "The collisions so far, or those of one line: dicts with kind (rapid, neck, shank, "
           "holder, fixture), line, tool, time_s, place_mm, volume_mm3.")
      .def("report", &report,
           "The report so far, as a dict like the one of kibori.mill. With a target, it contains "
           "the comparison with it.")
      .def(
          "model",
          [](Milling& self) {
            return self.with([](Bench& bench) {
              bench.session->settle();
              const TriDexel& model = *bench.plan.model;
              return std::make_shared<Model>(done(Workpiece::of(
                  std::make_unique<TriDexel>(model.snapshot(), model.material_bounds()),
                  bench.plan.materials)));
            });
          },
          "The remaining material, as a new Model. Later commands do not change it.")
      .def(
          "surface",
          [snapshot](Milling& self, int threads) {
            return surface_arrays(snapshot(self), threads);
          },
          py::arg("threads") = 1, "The surface of the remaining material, as arrays.")
      .def_property_readonly(
          "volume_mm3",
          [snapshot](Milling& self) {
            const Snapshot state = snapshot(self);
            const py::gil_scoped_release no_gil;
            return state.volume_mm3();
          },
          "Volume of the remaining material [mm^3].")
      .def_property_readonly(
          "hash",
          [snapshot](Milling& self) {
            const Snapshot state = snapshot(self);
            const py::gil_scoped_release no_gil;
            return state.content_hash();
          },
          "Hash of the remaining material. Equal models have equal hashes.");
}

}  // namespace

void bind_milling(py::module_& module) {
  bind_mill(module);
  module.def("ball_end_mill", &ball_end_mill, py::arg("radius"), py::arg("length"),
             "A ball end mill [mm]: a ball and a cylinder of the same radius, up to length.");
  bind_class(module);
}

}  // namespace kibori::python
