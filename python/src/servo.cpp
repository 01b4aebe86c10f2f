// SPDX-License-Identifier: MIT
// The servo loop in the script's own process: a C++ thread that never waits for Python.
#include <algorithm>
#include <mutex>

#include <kibori/run/documents.h>
#include <kibori/report/tick_row.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>

#include "python/src/materials.h"
#include "python/src/model.h"

namespace kibori::python {
namespace {

constexpr double kAboveMm = 20;  // initial height of a virtual hand
// Speed of the virtual hand [mm/s]: like a real hand, and slow enough that the safety stage does
// not trip.
constexpr double kHandSpeed = 300;

struct ServoChoice {
  Tool tool;
  Mode mode = Mode::cut;
  std::string device;
  std::optional<Pose> at;  // initial pose of the virtual hand; none: above the body
  double rate_hz = 1000;
  ForceModel force = ForceModel::series;
  std::optional<double> stiffness_n_mm;  // at the device
  double strength_n = kHandStrengthN, hand_share = kPoweredShare;
  std::string material;  // material of deposits; empty: the first
  bool keep_forces = true;
};

class Servo {
 public:
  // Carves the document at `path`.
  Servo(const std::filesystem::path& path, BodyId worked_on, const ServoChoice& choice) {
    std::unique_ptr<Document> document = value_of(Document::open(path, Document::Access::write));
    std::unique_ptr<TriDexel> model = value_of(document->load());
    if (worked_on != document->active()) {
      must(document->choose(worked_on));
      const Body& chosen = *document->worked_on()->find(worked_on);
      model = std::make_unique<TriDexel>(chosen.model, chosen.material_bounds);
    }
    WorkedBody body = value_of(worked_body(*document->worked_on(), worked_on));
    check_mode(choice.mode, body);
    others_no_go_ = body.no_go != nullptr;
    const Vec3 centre =
        body.pose.to_world(model->lattice().to_mm(model->material_bounds().centre()));
    LiveSettings settings;
    settings.rate_hz = choice.rate_hz;
    settings.tool = choice.tool;
    settings.mode = choice.mode;
    settings.brush.strength = default_strength(choice.mode);
    settings.materials = document_materials(*document);
    settings.material = number_of(settings.materials, choice.material);
    settings.model = choice.force;
    settings.workspace = Workspace(centre);
    settings.log = settings.watched = true;
    const Box lattice = model->lattice().to_mm(model->lattice().whole());
    const double half_height = (body.pose.frame.row(2).cwiseAbs() * lattice.size())[0] / 2;
    const Pose above{body.pose.to_world(lattice.centre()) + Vec3(0, 0, half_height + kAboveMm),
                     Mat3::Identity()};
    std::unique_ptr<Device> device =
        device_of(choice.device, choice.rate_hz, choice.at.value_or(above), centre);
    // As in the studio, the hand's full strength corresponds to the device's max force.
    const DeviceCapabilities& can = device->capabilities();
    if (!(choice.strength_n > 0 && choice.strength_n < 1e6))
      throw Failure("the strength of a hand must be above 0 N");
    if (can.dof_out > 0 && can.force_n > 0) settings.force_scale = can.force_n / choice.strength_n;
    const double max_stable = 2 * choice.rate_hz * can.damping_ns_mm * (1 - 1e-9);
    settings.spring.stiffness_n_mm =
        choice.stiffness_n_mm.value_or(std::min(can.stiffness_n_mm, max_stable)) /
        settings.force_scale;
    settings.spring.strength_n = choice.strength_n;
    settings.spring.hand_share = choice.hand_share;
    published_ = {path.filename().string(), device->capabilities().name, choice.rate_hz,
                  model->lattice(), settings.materials};
    live_ = value_of(LiveCarving::make(std::move(model), std::move(device), settings));
    live_->context().set_body(body);
    writer_.emplace(*live_, std::move(document), choice.keep_forces);
    writer_->start();
    live_->start();
  }
  Servo(const Servo&) = delete;
  Servo& operator=(const Servo&) = delete;
  ~Servo() { stop(); }

  std::string about() const { return about_rows(published_); }

  // Sets the virtual hand's target.
  void aim(const Pose& pose) {
    const std::scoped_lock lock(stopping_, aiming_);
    if (!running_) throw Failure("the servo loop has ended");
    if (!virtual_) throw Failure("aim() works only with the virtual device, not with a real one");
    aims_.put(pose);
  }

  void hold(const Tool& tool, Mode mode, const std::string& material) {
    if (const Status can = check_tool(tool); !can) throw Failure(can.error());
    const std::lock_guard<std::mutex> lock(stopping_);
    if (!running_) throw Failure("the servo loop has ended");
    if (others_no_go_ && reshapes(mode)) throw Failure(kNoReshaping);
    const uint8_t number = number_of(published_.materials, material);
    if (!live_->post([tool, mode, number](ServoContext& context) {
          context.settings().mode = mode;
          context.settings().material = number;
          context.settings().brush.strength = default_strength(mode);
          context.change_tool(tool);
        }))
      throw Failure("the servo loop is busy; try again later");
  }

  // The rows since the last call.
  std::vector<TickRow> ticks() {
    const std::lock_guard<std::mutex> lock(reading_);
    std::vector<TickRow> rows;
    LiveTick tick;
    while (live_->next_tick(tick)) append_rows(tick, rows);
    return rows;
  }

  // Ends the loop. The document then contains all strokes.
  void stop() {
    const std::lock_guard<std::mutex> lock(stopping_);
    if (!std::exchange(running_, false)) return;
    live_->stop();
    writer_->stop();
    statistics_ = live_->statistics();
    unsaved_ = writer_->settled();
    writer_.reset();
  }
  // The reason why the document is incomplete, and the path of the rest. Empty: it is complete.
  std::string unsaved() {
    const std::lock_guard<std::mutex> lock(stopping_);
    return unsaved_;
  }

  // The statistics of the loop, after it has ended.
  ServoStatistics statistics() {
    const std::lock_guard<std::mutex> lock(stopping_);
    if (running_) throw Failure("the statistics of the servo loop are known when it has ended");
    return statistics_;
  }

 private:
  static constexpr const char* kNoReshaping =
      "nothing can be reshaped next to a protected body; use cut, deposit or touch";
  static void check_mode(Mode mode, const WorkedBody& body) {
    if (body.locked) throw Failure("the body is locked or protected and can't be carved");
    if (body.no_go && reshapes(mode)) throw Failure(kNoReshaping);
  }
  static uint8_t number_of(const std::vector<Material>& materials, const std::string& name) {
    if (name.empty()) return 0;
    for (size_t i = 0; i < materials.size(); i++)
      if (materials[i].name == name) return static_cast<uint8_t>(i);
    std::string there;
    for (const Material& material : materials) there += (there.empty() ? "" : ", ") + material.name;
    throw Failure("the model has no material '" + sanitize_message(name) + "'; it has " + there +
                  "; other materials are added by a deposit");
  }
  std::unique_ptr<Device> device_of(const std::string& name, double rate_hz, const Pose& at,
                                    const Vec3& centre) {
    virtual_ = name == "virtual";
    if (!virtual_) return value_of(open_device(name));
    return std::make_unique<VirtualDevice>(
        wristed_hand("a virtual device", rate_hz),
        [this, centre, aim = at, place = at.tip,
         last_s = 0.0](double time_s) mutable -> VirtualDevice::Target {
          aims_.take(aim);
          const Vec3 displacement = aim.tip - place;
          const double max_step = kHandSpeed * (time_s - last_s);
          last_s = time_s;
          place = displacement.norm() > max_step
                      ? Vec3(place + max_step / displacement.norm() * displacement)
                      : aim.tip;
          return {place - centre, aim.frame, 0};
        });
  }

  std::mutex aiming_, reading_, stopping_;
  bool virtual_ = false, others_no_go_ = false;
  LatestValue<Pose> aims_;  // declared before the device, which reads it
  Published published_;
  std::unique_ptr<LiveCarving> live_;
  std::optional<DocumentWriter> writer_;
  bool running_ = true;
  ServoStatistics statistics_;
  std::string unsaved_;
};

py::dict times(const Histogram& of) {
  py::dict dict;
  for (const auto& [name, share] : {std::pair{"p50", 0.5}, {"p99", 0.99}, {"p999", 0.999}})
    dict[name] = static_cast<double>(of.quantile_ns(share)) / 1000;
  dict["max"] = static_cast<double>(of.max_ns()) / 1000;
  return dict;
}

}  // namespace

void bind_servo(py::module_& module) {
  py::class_<Servo>(module, "_Servo")
      .def(py::init([](const std::filesystem::path& path, BodyId body, const Tool& tool,
                       const std::string& mode, const std::string& device,
                       const std::optional<Doubles>& at, double rate, const std::string& force,
                       const std::optional<double>& stiffness, double strength,
                       const std::string& powered, const std::string& material, bool keep_forces) {
        const ServoChoice choice{tool,
                                 named<Mode>("mode", mode),
                                 device,
                                 at ? std::optional(pose_of(*at)) : std::nullopt,
                                 rate,
                                 named<ForceModel>("force model", force),
                                 stiffness,
                                 strength,
                                 share_of(powered),
                                 material,
                                 keep_forces};
        const py::gil_scoped_release no_gil;
        return std::make_unique<Servo>(path, body, choice);
      }))
      .def_property_readonly("about", &Servo::about)
      .def("aim", [](Servo& self, const Doubles& pose) { self.aim(pose_of(pose)); })
      .def("hold",
           [](Servo& self, const Tool& tool, const std::string& mode, const std::string& material) {
             const Mode value = named<Mode>("mode", mode);
             const py::gil_scoped_release no_gil;
             self.hold(tool, value, material);
           })
      .def("ticks",
           [](Servo& self) {
             const std::vector<TickRow> rows = [&] {
               const py::gil_scoped_release no_gil;
               return self.ticks();
             }();
             return py::bytes(reinterpret_cast<const char*>(rows.data()),
                              rows.size() * sizeof(TickRow));
           })
      .def("stop",
           [](Servo& self) {
             const py::gil_scoped_release no_gil;
             self.stop();
           })
      .def_property_readonly("unsaved", &Servo::unsaved)
      .def("statistics", [](Servo& self) {
        const ServoStatistics s = self.statistics();
        py::dict dict;
        dict["ticks"] = s.ticks;
        dict["missed"] = s.missed;
        dict["seconds"] = s.seconds;
        dict["compute_us"] = times(s.compute_ns);
        dict["late_us"] = times(s.late_ns);
        return dict;
      });
}

}  // namespace kibori::python
