// SPDX-License-Identifier: MIT
#include "apps/cli/servo_commands.h"

#include <csignal>
#include <memory>
#include <vector>

#include <nlohmann/json.hpp>

#include <kibori/run/documents.h>
#include <kibori/run/servo_run.h>
#include <kibori/devices/registry.h>

#include "apps/cli/common.h"
#include "apps/cli/outputs.h"
#include "apps/publish/publisher.h"

using namespace kibori;

namespace {

volatile std::sig_atomic_t interrupted = 0;

}  // namespace

ServoCommands::ServoCommands(CLI::App& app) {
  devices_ = app.add_subcommand("devices",
                                "List force-feedback devices, and why others are not available");
  devices_->add_flag("--json", json_, "as JSON");

  servo_ = app.add_subcommand(
      "servo",
      "Carve with a simulated hand or a device in real time, and report the timing of the loop");
  servo_->add_option("SCENE", scene_,
                     "scene with stock, first tool and moves; the simulated hand moves back and "
                     "forth along the moves. Without a scene, a ball scrapes over a block");
  servo_->add_option("--device", device_, "device to use: a name that 'kibori devices' lists")
      ->capture_default_str();
  servo_
      ->add_option("--record", record_,
                   "record the device's readings, for --device replay:FILE.csv")
      ->type_name("FILE.csv");
  servo_->add_option("-o,--output", document_, "write every stroke to a document while carving")
      ->type_name("FILE.kibori");
  servo_
      ->add_flag("--keep-forces", keep_forces_,
                 "store force and moment of every tick in the document")
      ->needs("-o");
  add_publish(*servo_, publish_);
  servo_->add_option("--seconds", seconds_, "duration of the run in seconds")
      ->check(kPositive)
      ->capture_default_str();
  servo_->add_option("--rate", rate_hz_, "ticks per second, 100 to 4000")
      ->type_name("HZ")
      ->check(CLI::Range(100.0, 4000.0))
      ->capture_default_str();
  servo_
      ->add_option("--model", model_,
                   "series: a spring connects hand and tool; energy, paper: the tool is at the "
                   "hand; default: the scene's model")
      ->check(CLI::IsMember(names_of(ForceModel{})));
  servo_
      ->add_option("--stiffness", stiffness_n_mm_,
                   "stiffness of the spring; default: one that suits the device")
      ->type_name("N/MM")
      ->check(kPositive);
  servo_->add_flag("--no-surface", no_surface_, "do not update the surface on a second thread");
  servo_->add_flag("--json", json_, "as JSON, with all histograms");
}

int ServoCommands::run_devices() const {
  const std::vector<DeviceFound> found = find_devices();
  if (json_) {
    nlohmann::json all = nlohmann::json::array();
    for (const auto& d : found)
      all.push_back({{"name", d.name}, {"present", d.present}, {"text", d.text}});
    std::printf("%s\n", all.dump(2).c_str());
    return written();
  }
  for (const auto& d : found)
    std::printf("%-24s %-4s %s\n", d.name.c_str(), d.present ? "yes" : "no",
                sanitize_message(d.text).c_str());
  return written();
}

int ServoCommands::run_servo() const {
  Scene scene = servo_scene();
  if (!scene_.empty()) {
    Result<Scene> read = read_scene(scene_);
    if (!read) return bad_input(read.error());
    scene = std::move(read).value();
  }
  Outputs outputs;
  outputs.reads(scene_);
  for (const std::filesystem::path& read : scene.files) outputs.reads(read);
  if (device_.starts_with("replay:")) outputs.reads(device_.substr(7));
  outputs.makes_document("-o", document_);
  outputs.writes("--record", record_);
  if (const Status can = outputs.check(); !can) return bad_input(can.error());
  ServoRunOptions options;
  options.seconds = seconds_;
  options.rate_hz = rate_hz_;
  if (!model_.empty() || scene_.empty())
    options.model = value_of<ForceModel>(model_).value_or(ForceModel::series);
  if (stiffness_n_mm_ > 0) options.stiffness_n_mm = stiffness_n_mm_;
  options.surface = !no_surface_;
  options.record = record_;
  if (!document_.empty() && !is_document(document_))
    return bad_input(document_ + ": is not a document's name; name a file that ends in .kibori");
  options.document = document_;
  options.keep_forces = keep_forces_;
  options.progress = [](double share) { show_progress("running", share); };
  std::unique_ptr<Device> device;
  if (device_ != "virtual") {
    Result<std::unique_ptr<Device>> opened = open_device(device_);
    if (!opened) return bad_input(opened.error());
    device = std::move(opened).value();
  }
  std::unique_ptr<Publisher> publisher;
  if (!publish_.empty()) {
    Result<std::unique_ptr<Publisher>> opened = Publisher::open(publish_);
    if (!opened) return bad_input(opened.error());
    publisher = std::move(opened).value();
    std::fprintf(stderr, "%s\n", publisher->where().c_str());
    options.begins = [&](const std::string& device_name, const Lattice& lattice) {
      publisher->about({std::filesystem::path(document_).filename().string(), device_name, rate_hz_,
                        lattice, scene.materials});
    };
    options.on_ticks = [&](const std::vector<LiveTick>& ticks) {
      for (const LiveTick& tick : ticks) publisher->add(tick);
      publisher->flush();
    };
  }
  // Ctrl-C ends the run cleanly: the force is switched off, and the recording is saved.
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  std::signal(SIGHUP, [](int) { interrupted = 1; });
  options.cancelled = [] { return interrupted != 0; };
  const Result<ServoReport> report = kibori::run_servo(scene, std::move(device), options);
  if (!report) return bad_input(report.error());
  std::fputs((json_ ? servo_report_json(report.value()) + "\n" : servo_report_text(report.value()))
                 .c_str(),
             stdout);
  if (!report.value().unsaved.empty()) return bad_input(report.value().unsaved);
  return written();
}
