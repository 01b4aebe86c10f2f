// SPDX-License-Identifier: MIT
#include <kibori/run/servo_run.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include <kibori/base/file.h>
#include <kibori/base/percent.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/devices/recording.h>
#include <kibori/document/rescue.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

// The motion of the hand along the scene's moves, over time.
struct HandPath {
  struct Leg {
    double begin_s, end_s;
    Pose from;
    Vec3 travel_mm, turn_rad;
  };
  std::vector<Leg> legs;

  double seconds() const { return legs.empty() ? 0 : legs.back().end_s; }
  // The pose after t seconds. At its end, the path is followed back to its start, and so on.
  Pose at(double t) const {
    const double all = seconds();
    if (!(all > 0)) return legs.front().from;
    const double round = std::fmod(t, 2 * all), there = round < all ? round : 2 * all - round;
    const auto leg =
        std::find_if(legs.begin(), legs.end() - 1, [&](const Leg& l) { return there <= l.end_s; });
    const double length = leg->end_s - leg->begin_s;
    const double share = length > 0 ? std::clamp((there - leg->begin_s) / length, 0.0, 1.0) : 1;
    return ToolMotion{leg->from, leg->travel_mm, leg->turn_rad}.at(share);
  }
};

Result<HandPath> hand_path(const Scene& scene) {
  HandPath path;
  const Move& first = scene.moves.front();
  Pose pose{first.to_mm, frame_from_axis(first.axis, first.roll_rad)};
  double time = 0;
  path.legs.push_back({0, 0, pose, Vec3::Zero(), Vec3::Zero()});
  for (size_t i = 1; i < scene.moves.size(); i++) {
    const Result<MovePlan> plan = plan_move(scene, scene.moves[i - 1], scene.moves[i]);
    if (!plan) return Error{plan.error()};
    const double length =
        static_cast<double>(plan.value().ticks + plan.value().dwell_ticks) / scene.rate_hz;
    const auto go = [&](const Vec3& travel, const Vec3& turn_rad, double seconds) {
      path.legs.push_back({time, time + seconds, pose, travel, turn_rad});
      pose = ToolMotion{pose, travel, turn_rad}.at(1);
      time += seconds;
    };
    if (!plan.value().path) {
      go(scene.moves[i].to_mm - pose.tip, plan.value().turn_rad, length);
      continue;
    }
    const MovePath& move_path = *plan.value().path;
    for (size_t k = 0; k < move_path.places.size(); k++) {
      const double share =
          (move_path.at_mm[k] - (k > 0 ? move_path.at_mm[k - 1] : 0)) / move_path.length_mm();
      go(move_path.places[k].tip - pose.tip,
         move_path.leads ? rotation_between(pose.frame, move_path.places[k].frame)
                         : Vec3(Vec3::Zero()),
         share * length);
    }
  }
  return path;
}

// A thread that only wakes up at each tick. It measures the delay of the machine itself.
class EmptyLoop {
 public:
  EmptyLoop(double rate_hz, bool wanted) {
    if (!wanted) return;
    thread_ = std::thread([this, rate_hz] {
      enter_real_time();
      ServoClock clock(rate_hz);
      while (!stopping_.load(std::memory_order_relaxed)) {
        clock.wait();
        clock.done();
      }
      late_ = clock.statistics().late_ns;
    });
  }
  ~EmptyLoop() { stop(); }
  Histogram stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return late_;
  }

 private:
  std::atomic<bool> stopping_{false};
  Histogram late_;
  std::thread thread_;
};

nlohmann::json quantiles(const Histogram& h) {
  const auto us = [&](double share) { return static_cast<double>(h.quantile_ns(share)) / 1000; };
  nlohmann::json bins = nlohmann::json::array();
  h.for_bins([&](uint64_t from, uint64_t to, uint64_t count) {
    bins.push_back({static_cast<double>(from) / 1000, static_cast<double>(to) / 1000, count});
  });
  return {{"p50", us(0.5)},
          {"p99", us(0.99)},
          {"p999", us(0.999)},
          {"max", static_cast<double>(h.max_ns()) / 1000},
          {"bins", std::move(bins)}};
}

// Appends the quantiles of a histogram, and a bar for each octave.
void draw(std::string& text, const char* name, const Histogram& h) {
  char line[200];
  const auto us = [&](double share) { return static_cast<double>(h.quantile_ns(share)) / 1000; };
  std::snprintf(line, sizeof line, "%-10s p50 %8.1f   p99 %8.1f   p99.9 %8.1f   max %8.1f us\n",
                name, us(0.5), us(0.99), us(0.999), static_cast<double>(h.max_ns()) / 1000);
  text += line;
  std::array<uint64_t, 40> octaves{};
  h.for_bins([&](uint64_t from, uint64_t, uint64_t count) {
    octaves[std::min<size_t>(octaves.size() - 1, static_cast<size_t>(std::bit_width(from)))] +=
        count;
  });
  for (size_t i = 0; i < octaves.size(); i++) {
    if (octaves[i] == 0) continue;
    // Logarithmic, so that rare values are visible.
    const auto stars = static_cast<int>(4 * std::log10(static_cast<double>(octaves[i])) + 1);
    std::snprintf(line, sizeof line, "  below %10.1f us %10llu  %.*s\n",
                  std::ldexp(1.0, static_cast<int>(i)) / 1000,
                  static_cast<unsigned long long>(octaves[i]), std::min(stars, 40),
                  "########################################");
    text += line;
  }
}

double miss_ratio(const ServoStatistics& s) {
  return s.ticks == 0 ? 0 : static_cast<double>(s.missed) / static_cast<double>(s.ticks + s.missed);
}

}  // namespace

Scene servo_scene() {
  Scene scene;
  scene.file = "the built-in scene";
  scene.stock.shape = StockBlock{Vec3(80, 50, 30)};
  scene.stock.pitch_mm = 0.25;
  scene.tools = {BallTool{4}};
  Material oak;
  oak.name = "oak";
  oak.u = 0.05;
  oak.yield_n = 0.1;
  scene.materials = {oak};
  Move start;
  start.to_mm = Vec3(5, 5, 31);
  scene.moves = {start};
  // Rows 1.5 mm apart. Each is 0.1 mm deeper than the one before.
  for (int row = 0; row <= 26; row++)
    for (const bool back : {false, true}) {
      Move move;
      move.to_mm = Vec3((row % 2 == 1) != back ? 75 : 5, 5 + 1.5 * row, 29.5 - 0.1 * row);
      move.speed_mm_s = 50;
      scene.moves.push_back(move);
    }
  return scene;
}

namespace {

// Reports an error for the parts of a scene that a servo run does not support. They must not be
// ignored silently.
Status check_scene(const Scene& scene) {
  const char* unknown = nullptr;
  if (!scene.no_go.empty()) unknown = "[[no_go]]";
  if (!scene.splines.empty()) unknown = "[[spline]]";
  if (!scene.cutters.empty()) unknown = "[[cutter]]";
  if (scene.moves.front().second) unknown = "a second hand";
  if (!unknown) return Ok{};
  return Error{scene.file + ": a servo run does not support " + unknown +
               "; remove it from the scene, or run the scene with 'kibori carve'"};
}

// A virtual device whose hand moves back and forth along the scene's moves. `centre`: the position
// of the device's origin in the model.
Result<std::unique_ptr<Device>> virtual_hand(const Scene& scene, double rate_hz,
                                             const Vec3& centre) {
  Result<HandPath> path = hand_path(scene);
  if (!path) return Error{path.error()};
  return std::unique_ptr<Device>(std::make_unique<VirtualDevice>(
      wristed_hand("a virtual device", rate_hz),
      [path = std::move(path).value(), centre](double t) -> VirtualDevice::Target {
        const Pose pose = path.at(t);
        return {pose.tip - centre, pose.frame, 0};
      }));
}

// Wraps the device so that its readings are recorded. `recording` receives a pointer to the
// wrapper.
Result<std::unique_ptr<Device>> recorded_device(std::unique_ptr<Device> device,
                                                const ServoRunOptions& options,
                                                RecordingDevice*& recording) {
  if (const Status writable = check_writable(options.record); !writable)
    return Error{writable.error()};
  // Room for one second more, because a run may stop slightly after its time.
  auto wrapped = std::make_unique<RecordingDevice>(
      std::move(device), 1 / options.rate_hz,
      static_cast<size_t>((options.seconds + 1) * options.rate_hz) + 1);
  recording = wrapped.get();
  return std::unique_ptr<Device>(std::move(wrapped));
}

// The settings for the scene's first tool and its first move that is not `off`.
LiveSettings live_settings(const Scene& scene, const ServoRunOptions& options,
                           const Lattice& lattice, const DeviceCapabilities& device) {
  LiveSettings settings;
  settings.rate_hz = options.rate_hz;
  settings.tool = scene.tools.front();
  settings.materials = scene.materials;
  for (size_t i = scene.moves.size(); i-- > 1;)
    if (scene.moves[i].mode != Mode::off) {
      settings.mode = scene.moves[i].mode;
      settings.material = scene.moves[i].material;
      settings.brush = scene.moves[i].brush;
    }
  settings.symmetry = scene.symmetry;
  if (!scene.symmetry_centred) settings.symmetry.centre_mm = centre_of(lattice);
  settings.crumbs = scene.crumbs;
  settings.model = options.model.value_or(scene.force.law.model);
  if (scene.force.series()) settings.spring = scene.force.spring;
  settings.spring.stiffness_n_mm = options.stiffness_n_mm.value_or(
      scene.force.series() ? scene.force.spring.stiffness_n_mm : device.stiffness_n_mm);
  settings.log = !options.document.empty();
  settings.watched = static_cast<bool>(options.on_ticks);
  return settings;
}

// Follows a running servo until its time is over. It passes ticks to the caller and snapshots to
// the surface.
class ServoWatch {
 public:
  ServoWatch(LiveCarving& live, const ServoRunOptions& options) : live_(live), options_(options) {
    if (options.surface) surface_.emplace(live.context().model().snapshot());
  }

  void run(ServoReport& report) {
    const auto begin = std::chrono::steady_clock::now();
    const auto elapsed = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    Snapshot snapshot;
    while (elapsed() < options_.seconds && !(options_.cancelled && options_.cancelled())) {
      report_ticks();
      if (live_.latest(snapshot)) {
        report.snapshots++;
        if (surface_) report.surface_chunks += surface_->update(snapshot).size();
        snapshot = {};
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
      if (options_.progress) options_.progress(std::min(1.0, elapsed() / options_.seconds));
    }
  }

  void report_ticks() {
    if (!options_.on_ticks) return;
    ticks_.clear();
    do ticks_.emplace_back();
    while (live_.next_tick(ticks_.back()));
    ticks_.pop_back();
    if (!ticks_.empty()) options_.on_ticks(ticks_);
  }

 private:
  LiveCarving& live_;
  const ServoRunOptions& options_;
  std::optional<LiveSurface> surface_;
  std::vector<LiveTick> ticks_;
};

// Writes everything that is pending. Returns why the document holds only the beginning, and where
// the rest is. Returns an empty text if the document is complete.
std::string finish_document(DocumentWriter& writer, const std::vector<Material>& materials) {
  writer.stop();
  Document& written = writer.document();
  // A failed thumbnail is not an error.
  if (const BodyList* const bodies = written.worked_on())
    static_cast<void>(keep_thumbnail(written, written.head(), BodyList(*bodies), materials, 1));
  return writer.settled();
}

}  // namespace

Result<ServoReport> run_servo(const Scene& scene, std::unique_ptr<Device> given,
                              const ServoRunOptions& options) {
  if (const Status fits = check_scene(scene); !fits) return Error{fits.error()};
  Result<std::unique_ptr<TriDexel>> stock = make_stock(scene.stock, scene.file, {});
  if (!stock) return Error{stock.error()};
  const Lattice& lattice = stock.value()->lattice();
  const Vec3 centre = lattice.to_mm(stock.value()->material_bounds().centre());
  Result<std::unique_ptr<Device>> device = std::move(given);
  if (!device.value()) device = virtual_hand(scene, options.rate_hz, centre);
  if (!device) return Error{device.error()};
  RecordingDevice* recording = nullptr;
  if (!options.record.empty())
    device = recorded_device(std::move(device).value(), options, recording);
  if (!device) return Error{device.error()};
  LiveSettings settings = live_settings(scene, options, lattice, device.value()->capabilities());
  settings.workspace = Workspace(centre);
  std::unique_ptr<Document> document;
  if (settings.log) {
    Result<std::unique_ptr<Document>> created =
        new_document(options.document, scene, *stock.value());
    if (!created) return Error{created.error()};
    document = std::move(created).value();
  }
  ServoReport report;
  report.device = device.value()->capabilities().name;
  report.rate_hz = options.rate_hz;

  auto made = LiveCarving::make(std::move(stock).value(), std::move(device).value(), settings);
  if (!made) {
    // A run that did not start leaves no file.
    if (std::exchange(document, nullptr)) remove_document(options.document);
    return Error{made.error()};
  }
  LiveCarving& live = *made.value();
  ServoWatch watch(live, options);
  std::optional<DocumentWriter> writer;
  if (document) writer.emplace(live, std::move(document), options.keep_forces).start();
  EmptyLoop empty(options.rate_hz, options.empty_loop);
  if (options.begins) options.begins(report.device, live.context().model().lattice());
  live.start();
  watch.run(report);
  live.stop();
  watch.report_ticks();
  if (writer) report.unsaved = finish_document(*writer, scene.materials);
  report.empty_late_ns = empty.stop();
  if (options.progress) options.progress(1);
  if (recording) {
    report.left_out = recording->left_out();
    if (const Status saved = recording->save(options.record); !saved) return Error{saved.error()};
  }
  report.complaint = live.context().device().complaint();
  report.scheduling = live.scheduling();
  report.servo = live.statistics();
  report.totals = live.totals();
  report.trip = live.totals().trip;
  report.min_energy_mj = live.context().passivity().min_mj();
  return report;
}

std::string servo_report_text(const ServoReport& r) {
  std::string text;
  char line[400];
  std::snprintf(line, sizeof line, "device     %s\nthread     %s\n", r.device.c_str(),
                r.scheduling.c_str());
  text += line;
  std::snprintf(line, sizeof line, "ticks      %llu at %g Hz in %.1f s, %llu missed (%s)\n",
                static_cast<unsigned long long>(r.servo.ticks), r.rate_hz, r.servo.seconds,
                static_cast<unsigned long long>(r.servo.missed),
                percent(miss_ratio(r.servo)).c_str());
  text += line;
  draw(text, "compute", r.servo.compute_ns);
  draw(text, "period", r.servo.period_ns);
  draw(text, "late", r.servo.late_ns);
  if (r.empty_late_ns.count() > 0) draw(text, "empty loop", r.empty_late_ns);
  std::snprintf(line, sizeof line,
                "carved     %.4g mm3 removed, largest force %.3g N computed, %.3g N given\n"
                "surface    %llu snapshots, %llu chunks rebuilt\n",
                r.totals.removed_mm3, r.totals.max_computed_n, r.totals.max_given_n,
                static_cast<unsigned long long>(r.snapshots),
                static_cast<unsigned long long>(r.surface_chunks));
  text += line;
  if (r.left_out > 0)
    text += "recording  without the last " + std::to_string(r.left_out) +
            " ticks, because the run was longer than --seconds\n";
  if (!r.complaint.empty()) text += "device     " + r.complaint + "\n";
  if (r.trip != Trip::none) text += "safety     " + trip_text(r.trip) + "\n";
  return text;
}

std::string servo_report_json(const ServoReport& r) {
  const nlohmann::json json = {
      {"device", r.device},
      {"scheduling", r.scheduling},
      {"rate_hz", r.rate_hz},
      {"seconds", r.servo.seconds},
      {"ticks", r.servo.ticks},
      {"missed", r.servo.missed},
      {"miss_ratio", miss_ratio(r.servo)},
      {"compute_us", quantiles(r.servo.compute_ns)},
      {"period_us", quantiles(r.servo.period_ns)},
      {"late_us", quantiles(r.servo.late_ns)},
      {"empty_loop_late_us", quantiles(r.empty_late_ns)},
      {"removed_mm3", r.totals.removed_mm3},
      {"max_force_N", r.totals.max_computed_n},
      {"max_given_N", r.totals.max_given_n},
      {"least_energy_mJ", r.min_energy_mj},
      {"snapshots", r.snapshots},
      {"surface_chunks", r.surface_chunks},
      {"recording_left_out", r.left_out},
      {"device_complaint", r.complaint},
      {"trip", r.trip == Trip::none ? nlohmann::json() : nlohmann::json(trip_text(r.trip))}};
  return json.dump(2);
}

}  // namespace kibori
