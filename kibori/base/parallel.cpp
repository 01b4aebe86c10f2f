// SPDX-License-Identifier: MIT
#include <kibori/base/parallel.h>

#include <algorithm>

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

namespace kibori::detail {

void run_on_pool(int threads, size_t count, void (*call)(void*, size_t), void* context) {
  oneapi::tbb::task_arena arena(std::min(threads, oneapi::tbb::info::default_concurrency()));
  arena.execute(
      [&] { oneapi::tbb::parallel_for(size_t{0}, count, [&](size_t i) { call(context, i); }); });
}

}  // namespace kibori::detail
