// SPDX-License-Identifier: MIT
#include <kibori/base/parallel.h>

#include <algorithm>
#include <map>

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace kibori::detail {

void run_on_pool(int threads, size_t count, void (*call)(void*, size_t), void* context) {
  // Each calling thread keeps its arenas. An arena per call would be expensive: TBB releases arenas
  // late, and until then they use memory and slow down all others.
  thread_local std::map<int, oneapi::tbb::task_arena> arenas;
  const int width = std::min(threads, oneapi::tbb::info::default_concurrency());
  arenas.try_emplace(width, width).first->second.execute([&] {
    oneapi::tbb::parallel_for(size_t{0}, count, [&](size_t i) { call(context, i); });
  });
}

}  // namespace kibori::detail
