// SPDX-License-Identifier: MIT
// The one way to run something on several threads: TBB's pool, behind one call.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace kibori {

namespace detail {
// Calls call(context, i) for i < count on up to `threads` threads of the pool.
void run_on_pool(int threads, size_t count, void (*call)(void*, size_t), void* context);
}  // namespace detail

// Runs f(0) ... f(count - 1) on up to `threads` threads and returns when all are done; on the
// caller's alone, in order and without allocation, if threads <= 1.
template <class F>
void run_parallel(int threads, size_t count, F&& f) {
  if (threads <= 1 || count <= 1) {
    for (size_t i = 0; i < count; i++) f(i);
    return;
  }
  // What is before happens before every f, and every f before what is after. The pool sees to that;
  // said once more for the thread sanitiser, which can't see into it.
  struct Job {
    F& f;
    std::atomic<size_t> order{0};
  } job{f};
  job.order.store(1, std::memory_order_release);
  detail::run_on_pool(
      threads, count,
      [](void* context, size_t i) {
        Job& own = *static_cast<Job*>(context);
        static_cast<void>(own.order.load(std::memory_order_acquire));
        own.f(i);
        own.order.fetch_add(1, std::memory_order_release);
      },
      &job);
  static_cast<void>(job.order.load(std::memory_order_acquire));
}

// Runs f(i, thread) for i < count, each i once, thread < max(threads, 1): for many short pieces
// that share scratch memory by thread.
template <class F>
void run_parallel_slices(int threads, size_t count, F&& f) {
  if (threads <= 1) {
    for (size_t i = 0; i < count; i++) f(i, size_t{0});
    return;
  }
  std::atomic<size_t> next{0};
  run_parallel(threads, static_cast<size_t>(threads), [&](size_t thread) {
    for (size_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < count;) f(i, thread);
  });
}

// Very short pieces go by the hundred: f(first, number) for ranges of kPieceSize and what is left.
inline constexpr size_t kPieceSize = 256;
template <class F>
void run_parallel_ranges(int threads, size_t count, F&& f) {
  run_parallel_slices(threads, (count + kPieceSize - 1) / kPieceSize, [&](size_t piece, size_t) {
    const size_t first = piece * kPieceSize;
    f(first, std::min(kPieceSize, count - first));
  });
}

// The same, f(i) for i < count.
template <class F>
void run_parallel_pieces(int threads, size_t count, F&& f) {
  run_parallel_ranges(threads, count, [&](size_t first, size_t number) {
    for (size_t i = first; i < first + number; i++) f(i);
  });
}

}  // namespace kibori
