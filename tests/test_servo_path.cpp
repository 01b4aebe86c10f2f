// SPDX-License-Identifier: MIT
// The servo path: 10^6 edits with snapshots taken and dropped beside them. Once the pools are ready, no
// allocation, no lock, no page fault. A program of its own, since it replaces malloc and friends.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <new>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <kibori/motion/stroke.h>

namespace {

std::atomic<bool> counting{false};
std::atomic<long> allocations{0}, locks{0};

void count(std::atomic<long>& counter) {
  if (counting.load(std::memory_order_relaxed)) counter.fetch_add(1, std::memory_order_relaxed);
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

int main(int argc, char** argv) {
  using namespace kibori;
  const long edits = argc > 1 ? std::atol(argv[1]) : 1'000'000;
  TriDexel model(make_lattice(Vec3(64, 48, 40), 0.5, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(64, 48, 40)}, 0);
  model.reserve(4000);
  const std::vector<Material> materials{{"a", 0.001, 2, 0, 0, {}}, {"b", 0.003, 7, 0, 0, {}}};
  const Tool tools[] = {Finger{0.4, 20}, BallTool{3},   Flat{2, 10},           Bull{2, 0.7, 10},
                        Cone{60, 2, 10}, Capsule{1, 8}, BoxTool{Vec3(3, 3, 3)}};
  uint64_t state = 1;
  const auto random = [&](double low, double high) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(state >> 11) / 9007199254740992.0;
  };
  Snapshot kept;
  const Snapshot start = model.snapshot();
  rusage before{}, after{};
  double work = 0;
  long done = 0;
  const auto run = [&](long many) {
    for (long i = 0; i < many;) {
      const Vec3 from(random(2, 62), random(2, 46), random(33, 42));
      const Tool& tool = tools[static_cast<size_t>(random(0, 6.999))];
      Stroke stroke(model, Pose{from, frame_from_axis(Vec3(random(-1, 1), random(-1, 1), 1))});
      const Vec3 step(random(-0.4, 0.4), random(-0.4, 0.4), random(-0.1, 0.05));
      const Mode mode = random(0, 1) < 0.15 ? Mode::deposit : random(0, 1) < 0.1 ? Mode::touch : Mode::cut;
      const Vec3 turn = random(0, 1) < 0.1 ? Vec3(0.002, 0.001, 0) : Vec3(0, 0, 0);
      for (int k = 1; k <= 40 && i < many; k++, i++, done++) {
        const auto tick = stroke.advance(tool, from + step * k, turn, mode, {ForceModel::energy, 6},
                                         materials, static_cast<uint8_t>(i % 2));
        work += tick.value().wrench.force.norm();
        if (done % 16 == 0) kept = model.snapshot();
        if (done % 20000 == 0) model.restore(start);
      }
    }
  };
  mlockall(MCL_CURRENT | MCL_FUTURE);  // as the servo does; where not permitted the pools' touching suffices
  run(20000);                          // the pools find their size
  getrusage(RUSAGE_SELF, &before);
  counting = true;
  run(edits);
  counting = false;
  getrusage(RUSAGE_SELF, &after);
  const long faults = after.ru_minflt - before.ru_minflt + after.ru_majflt - before.ru_majflt;
  std::printf("%ld edits: %ld allocations, %ld locks, %ld page faults (work %.3g)\n", edits,
              allocations.load(), locks.load(), faults, work);
  return allocations == 0 && locks == 0 && faults == 0 ? 0 : 1;
}
