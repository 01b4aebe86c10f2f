// SPDX-License-Identifier: MIT
// The servo path: 10^6 edits with snapshots taken and dropped beside them, and 10^6 ticks of
// carving by hand while other threads follow with the surface and write a document. Once the pools
// are ready, no allocation, no lock, no page fault on the servo's thread. A program of its own,
// since it replaces malloc and friends.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string>
#include <thread>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <kibori/devices/virtual_device.h>
#include <kibori/live/document_writer.h>
#include <kibori/live/live_carving.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/surface/surface.h>

namespace {

// Of one thread; the others may do as they like.
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

// std::mutex reaches the C library through this symbol.
extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto real =
      reinterpret_cast<int (*)(pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  count(locks);
  return real(mutex);
}

namespace {

using namespace kibori;

// Runs `work` after a rehearsal and says whether it kept off the system.
template <class F>
bool quiet(const char* what, long rehearsal, long many, F&& work) {
  work(rehearsal);
  long faults = 0;
  // Where memory can't be locked, the kernel may take a page away that was not used for a while.
  // That does not come again; what the work itself does comes every time.
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
  const std::vector<Material> materials{{"a", 0.001, 2, 0, 0, {}}, {"b", 0.003, 7, 0, 0, {}}};
  const Tool tools[] = {Finger{0.4, 20},
                        BallTool{3},
                        Flat{2, 10},
                        Bull{2, 0.7, 10},
                        Cone{60, 2, 10},
                        Capsule{1, 8},
                        BoxTool{Vec3(3, 3, 3)},
                        TaperedBall{0.7, 20, 2, 10}};
  uint64_t state = 1;
  const auto random = [&](double low, double high) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
  };
  Snapshot kept;
  const Snapshot start = model.snapshot();
  double work = 0;
  long done = 0;
  const auto run = [&](long wanted) {
    for (long i = 0; i < wanted;) {
      const Vec3 from(random(2, 62), random(2, 46), random(33, 42));
      const Tool& tool = tools[static_cast<size_t>(random(0, 7.999))];
      DirectTool stroke(model, Pose{from, frame_from_axis(Vec3(random(-1, 1), random(-1, 1), 1))});
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
  // To and fro over the top, at times above it, turning a little.
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
  auto made = LiveCarving::make(std::move(model), std::make_unique<VirtualDevice>(device, script),
                                settings);
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
  long done = 0;
  const bool good = quiet("ticks", 20000, many, [&](long count) {
    for (long i = 0; i < count; i++) {
      if (++done % 20000 == 0) {
        live.context().finish_stroke();
        live.context().model().restore(start);
        live.context().model_changed();
      }
      live.tick(0.001);
    }
  });
  stopping = true;
  follower.join();
  scribe.stop();
  const size_t strokes = scribe.document().steps().size();
  if (!scribe.trouble().empty()) std::printf("%s\n", scribe.trouble().c_str());
  std::filesystem::remove_all(folder);
  std::printf(
      "  (%zu strokes written; %.0f mm3 removed, %ld chunks of surface made anew, %llu ticks "
      "cut)\n",
      strokes, live.totals().removed_mm3, chunks,
      static_cast<unsigned long long>(live.totals().cutting_ticks));
  return good && chunks > 0 && strokes > 1 && scribe.trouble().empty() &&
         live.totals().cutting_ticks > static_cast<uint64_t>(many / 10);
}

}  // namespace

int main(int argc, char** argv) {
  // Of "edits" or "ticks", or both, so many.
  const std::string what = argc > 1 ? argv[1] : "both";
  const long many = argc > 2 ? std::atol(argv[2]) : 1'000'000;
  // As the servo does; where not permitted the pools' touching suffices.
  mlockall(MCL_CURRENT | MCL_FUTURE);
  const bool first = what == "ticks" || edits(many), second = what == "edits" || ticks(many);
  return first && second ? 0 : 1;
}
