// SPDX-License-Identifier: MIT
// The servo thread: 10^6 edits while snapshots are taken and dropped in parallel; 10^6 ticks of
// carving by hand while other threads follow with the surface and write a document; and as many
// ticks of strokes in all reshaping modes, which another thread computes. Once the pools are ready,
// the servo's thread makes no allocation, takes no lock and has no page fault. It is a separate
// program, because it replaces malloc and related functions.
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/live/live_carving.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/surface/surface.h>

#include "tests/every_tool.h"
#include "tests/modes.h"
#include "tests/plain_material.h"

namespace {

// Counters of one thread. Other threads are not restricted.
thread_local bool counting = false;
thread_local long allocations = 0, locks = 0;

void count(long& counter) {
  if (counting) counter++;
}

}  // namespace

extern "C" {
void* __libc_malloc(size_t);
void __libc_free(void*);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

void* malloc(size_t size) {
  count(allocations);
  return __libc_malloc(size);
}
void free(void* p) {
  if (p) count(allocations);
  __libc_free(p);
}
void* calloc(size_t n, size_t size) {
  count(allocations);
  return __libc_calloc(n, size);
}
void* realloc(void* p, size_t size) {
  count(allocations);
  return __libc_realloc(p, size);
}
void* aligned_alloc(size_t align, size_t size) {
  count(allocations);
  return __libc_memalign(align, size);
}
int posix_memalign(void** out, size_t align, size_t size) {
  count(allocations);
  *out = __libc_memalign(align, size);
  return *out ? 0 : 12;
}
}

// std::mutex::lock() calls this function of the C library.
extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto real =
      reinterpret_cast<int (*)(pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  count(locks);
  return real(mutex);
}

namespace {

using namespace kibori;

// Runs `work` after a rehearsal. Returns true if it made no allocation, took no lock and had no
// page fault.
template <class F>
bool quiet(const char* what, long rehearsal, long many, F&& work) {
  work(rehearsal);
  long faults = 0;
  // Without locked memory, the kernel may take a page away that was not used for a while. That does
  // not repeat; page faults of the work itself do.
  for (int tries = 0; tries < 2; tries++) {
    rusage before{}, after{};
    getrusage(RUSAGE_THREAD, &before);
    allocations = locks = 0;
    counting = true;
    work(many);
    counting = false;
    getrusage(RUSAGE_THREAD, &after);
    faults = after.ru_minflt - before.ru_minflt + after.ru_majflt - before.ru_majflt;
    std::printf("%ld %s: %ld allocations, %ld locks, %ld page faults\n", many, what, allocations,
                locks, faults);
    if (faults == 0 || allocations + locks > 0) break;
  }
  return allocations == 0 && locks == 0 && faults == 0;
}

bool edits(long many) {
  TriDexel model(make_lattice(Vec3(64, 48, 40), 0.5, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(64, 48, 40)}, 0);
  model.reserve(4000);
  const std::vector<Material> materials{test::plain_material("a", 0.001, 2),
                                        test::plain_material("b", 0.003, 7)};
  std::vector<Tool> tools;
  for (size_t shape = 0; shape < kToolShapes.size(); shape++)
    if (test::has_numbers(shape)) tools.push_back(test::usual_tool(shape, {2, 10}));
  uint64_t state = 1;
  const auto random = [&](double low, double high) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
  };
  Snapshot kept;
  const Snapshot start = model.snapshot();
  double work = 0;
  long done = 0;
  DirectTool stroke(model, Pose{});
  const auto run = [&](long wanted) {
    for (long i = 0; i < wanted;) {
      const Vec3 from(random(2, 62), random(2, 46), random(33, 42));
      const Tool& tool = tools[static_cast<size_t>(random(0, static_cast<double>(tools.size())))];
      stroke.place(Pose{from, frame_from_axis(Vec3(random(-1, 1), random(-1, 1), 1))});
      const Vec3 step(random(-0.4, 0.4), random(-0.4, 0.4), random(-0.1, 0.05));
      const Mode mode = random(0, 1) < 0.15  ? Mode::deposit
                        : random(0, 1) < 0.1 ? Mode::touch
                                             : Mode::cut;
      const Vec3 turn = random(0, 1) < 0.1 ? Vec3(0.002, 0.001, 0) : Vec3(0, 0, 0);
      for (int k = 1; k <= 40 && i < wanted; k++, i++, done++) {
        const auto tick = stroke.advance(tool, from + step * k, turn, mode, {ForceModel::energy, 6},
                                         materials, static_cast<uint8_t>(i % 2));
        work += tick.value().wrench.force.norm();
        if (done % 16 == 0) kept = model.snapshot();
        if (done % 20000 == 0) model.restore(start);
      }
    }
  };
  const bool good = quiet("edits", 20000, many, run);
  std::printf("  (work %.3g)\n", work);
  return good;
}

bool ticks(long many) {
  auto model = std::make_unique<TriDexel>(make_lattice(Vec3(64, 48, 40), 0.25, 4).value());
  model->fill_block({Vec3::Zero(), Vec3(64, 48, 40)}, 0);
  VirtualDeviceSettings device;
  device.capabilities.dof_in = device.capabilities.dof_out = 6;
  device.capabilities.torque_nmm = 100;
  // The hand moves back and forth over the top, sometimes above it, and turns a little.
  const auto script = [](double t) -> VirtualDevice::Target {
    return {Vec3(24 * std::sin(2.1 * t), 18 * std::sin(1.3 * t),
                 22 - 4.5 * std::sin(0.7 * t) * std::sin(0.7 * t)),
            rotation(Vec3(0.2 * std::sin(t), 0.1 * std::cos(t), 0)), 0};
  };
  LiveSettings settings;
  settings.tool = BallTool{4};
  settings.materials[0].u = 0.05;
  settings.materials[0].yield_n = 0.1;
  settings.spring = {0.3, 200, 0.2, 0.001};
  settings.workspace = Workspace(Vec3(32, 24, 20));
  settings.log = true;
  // The second hand adds material that the first hand cuts later.
  settings.second = settings;
  settings.second.tool = Flat{2, 8};
  settings.second.mode = Mode::deposit;
  const auto other = [script](double t) { return script(t + 1.7); };
  auto made = LiveCarving::make(std::move(model), std::make_unique<VirtualDevice>(device, script),
                                settings, std::make_unique<VirtualDevice>(device, other));
  if (!made) return std::printf("%s\n", made.error().c_str()), false;
  LiveCarving& live = *made.value();
  const Snapshot start = live.context().model().snapshot();
  char folder[] = "/tmp/kibori-servo-XXXXXX";
  if (!mkdtemp(folder)) return false;
  auto document = Document::create(std::filesystem::path(folder) / "ticks.kibori",
                                   live.context().model(), "{}");
  if (!document) return std::printf("%s\n", document.error().c_str()), false;
  DocumentWriter scribe(live, std::move(document).value());
  scribe.start();
  std::atomic<bool> stopping{false};
  long chunks = 0;
  std::thread follower([&] {
    LiveSurface surface(start);
    Snapshot snapshot;
    while (!stopping)
      if (live.latest(snapshot)) {
        chunks += static_cast<long>(surface.update(snapshot).size());
        snapshot = {};
      } else {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
  });
  live.context().safety().arm();
  live.context().second()->safety().arm();
  long done = 0;
  const bool good = quiet("ticks", 20000, many, [&](long count) {
    for (long i = 0; i < count; i++) {
      if (++done % 20000 == 0) {
        live.context().finish_stroke();
        live.context().model().restore(start);
        live.context().model_changed();
      }
      live.tick_at_once(0.001);
    }
  });
  stopping = true;
  follower.join();
  scribe.stop();
  const size_t strokes = scribe.document().steps().size();
  if (!scribe.write_error().empty()) std::printf("%s\n", scribe.write_error().c_str());
  std::filesystem::remove_all(folder);
  std::printf(
      "  (%zu strokes written; %.0f mm3 removed, %ld chunks of surface rebuilt, %llu ticks "
      "cut)\n",
      strokes, live.totals().removed_mm3, chunks,
      static_cast<unsigned long long>(live.totals().cutting_ticks));
  return good && chunks > 0 && strokes > 1 && scribe.write_error().empty() &&
         live.totals().cutting_ticks > static_cast<uint64_t>(many / 10);
}

// Stops all other threads of the process wherever they are, with any locks they hold, and resumes
// them.
class OtherThreads {
 public:
  static void rest() {
    const timespec moment{0, 20'000};
    nanosleep(&moment, nullptr);
  }
  OtherThreads() {
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
      const int id = std::stoi(task.path().filename());
      if (id != gettid()) ids_.push_back(id);
    }
    struct sigaction action {};
    action.sa_handler = [](int) {
      const int error = errno;
      stopped_++;
      while (held_) rest();
      stopped_--;
      errno = error;
    };
    action.sa_flags = SA_RESTART;
    sigaction(SIGUSR1, &action, nullptr);
  }
  // True if all are stopped.
  bool stop() const {
    held_ = true;
    for (const int id : ids_)
      if (syscall(SYS_tgkill, getpid(), id, SIGUSR1) != 0) return false;
    while (stopped_ != static_cast<int>(ids_.size())) rest();
    return true;
  }
  void resume() const {
    held_ = false;
    while (stopped_ != 0) rest();
  }

 private:
  std::vector<int> ids_;
  static inline std::atomic<bool> held_{false};
  static inline std::atomic<int> stopped_{0};
};

// Strokes of all reshaping modes, which are computed in parallel and committed between two ticks.
// Sometimes all other threads are stopped at a random point, and the ticks continue. This shows
// that no tick waits for another thread. The force on the hand does not jump at a commit.
bool dabs(long many) {
  constexpr double kForce = 8, kMaxJump = 0.05 * kForce;
  constexpr long kStage = 1000, kStill = 100;
  auto model = std::make_unique<TriDexel>(make_lattice(Vec3(64, 48, 40), 0.5, 8).value());
  model->fill_block({Vec3::Zero(), Vec3(64, 48, 40)}, 0);
  VirtualDeviceSettings device;
  device.capabilities.dof_in = device.capabilities.dof_out = 6;
  device.capabilities.force_n = kForce;
  device.capabilities.force_rate_n_s = 1e6;  // so that the safety stage hides no jump
  device.capabilities.torque_nmm = 100;
  device.capabilities.damping_ns_mm = 0.1;
  const auto script = [](double t) -> VirtualDevice::Target {
    return {Vec3(24 * std::sin(2.1 * t), 18 * std::sin(1.3 * t), 20.5 + 1.5 * std::sin(5 * t)),
            rotation(Vec3(0.2 * std::sin(t), 0.1 * std::cos(t), 0.5 * std::sin(3 * t))), 0};
  };
  LiveSettings settings;
  settings.mode = Mode::off;
  settings.tool = BallTool{3};
  settings.brush = {3, 0.5, Falloff::smooth, 0};
  settings.materials[0].u = 0.02;
  settings.spring = {0.3, 200, 0.2, 0.001};
  settings.workspace = Workspace(Vec3(32, 24, 20));
  settings.log = true;
  auto made = LiveCarving::make(std::move(model), std::make_unique<VirtualDevice>(device, script),
                                settings);
  if (!made) return std::printf("%s\n", made.error().c_str()), false;
  LiveCarving& live = *made.value();
  const Snapshot start = live.context().model().snapshot();
  char folder[] = "/tmp/kibori-servo-XXXXXX";
  if (!mkdtemp(folder)) return false;
  auto document =
      Document::create(std::filesystem::path(folder) / "dabs.kibori", live.context().model(), "{}");
  if (!document) return std::printf("%s\n", document.error().c_str()), false;
  DocumentWriter scribe(live, std::move(document).value());
  scribe.start();
  // Another thread follows with the surface, and requests the next action.
  std::atomic<bool> stopping{false};
  std::atomic<long> stage{0};
  std::thread other([&] {
    LiveSurface surface(start);
    Snapshot snapshot;
    for (long posted = 0; !stopping;) {
      if (posted < stage) {
        posted++;
        const std::vector<Mode>& modes = test::reshaping_modes();
        const Mode mode = modes[static_cast<size_t>(posted) % modes.size()];
        live.post([mode, lifted = posted % 5 == 0](ServoContext& c) {
          c.settings().mode = lifted ? Mode::off : mode;
        });
      }
      if (live.latest(snapshot)) {
        surface.update(snapshot);
        snapshot = {};
      } else {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      }
    }
  });
  live.context().safety().arm();
  live.tick(0.001);
  const OtherThreads others;
  long done = 0, commits = 0, standing_ticks = 0, touched = 0;
  double jump_at_commit = 0, jump = 0, largest = 0;
  Vec3 before = Vec3::Zero();
  Mode mode = Mode::off;
  bool good = quiet("ticks that reshape", 40000, many, [&](long count) {
    for (long i = 0; i < count; i++, done++) {
      if (done % kStage == 0) stage++;
      if (done % (40 * kStage) == 0) {
        live.context().finish_stroke();
        live.context().model().restore(start);
        live.context().model_changed();
      }
      const bool was = counting;
      if (done % kStage == kStage / 2) {
        counting = false;
        if (!others.stop()) std::abort();
        counting = was;
        standing_ticks++;
      }
      // As a servo waits for its next tick. Otherwise the ticks end before a dab is done.
      OtherThreads::rest();
      const LiveTick tick = live.tick_at_once(0.001);  // tick() waits for crumbs at a stroke's end
      const bool same = std::exchange(mode, live.context().settings().mode) == mode;
      const double step = (tick.given.force - before).norm();
      if (same && reshapes(mode)) {
        double& worst = tick.cutting ? jump_at_commit : jump;
        worst = std::max(worst, step);
        touched += tick.given.force.norm() > 0.01 * kForce;
      }
      commits += tick.cutting;
      before = tick.given.force;
      largest = std::max(largest, before.norm());
      if (done % kStage == kStage / 2 + kStill) {
        counting = false;
        others.resume();
        counting = was;
      }
    }
  });
  others.resume();
  stopping = true;
  other.join();
  scribe.stop();
  const size_t strokes = scribe.document().steps().size();
  if (!scribe.write_error().empty()) std::printf("%s\n", scribe.write_error().c_str());
  std::filesystem::remove_all(folder);
  const auto trip = live.totals().trip;
  std::printf(
      "  (%zu strokes written, %ld commits, all else stopped %ld times; force up to %.2f N in %ld "
      "ticks, from one tick to the next %.3f N at most at a commit, %.3f N elsewhere)\n",
      strokes, commits, standing_ticks, largest, touched, jump_at_commit, jump);
  if (trip != Trip::none) std::printf("%s\n", trip_text(trip).c_str());
  good &= scribe.write_error().empty() && trip == Trip::none;
  return good && commits > many / 200 && touched > many / 20 && strokes > 1 &&
         jump_at_commit <= kMaxJump;
}

}  // namespace

int main(int argc, char** argv) {
  // The first argument is "edits", "ticks", "dabs" or "all". The second one is their number.
  const std::string what = argc > 1 ? argv[1] : "all";
  const long many = argc > 2 ? std::atol(argv[2]) : 1'000'000;
  // The servo also locks its memory. If this is not permitted, the pools are in memory anyway,
  // because they have been written.
  mlockall(MCL_CURRENT | MCL_FUTURE);
  bool good = true;
  if (what == "all" || what == "edits") good &= edits(many);
  if (what == "all" || what == "ticks") good &= ticks(many);
  if (what == "all" || what == "dabs") good &= dabs(many);
  return good ? 0 : 1;
}
