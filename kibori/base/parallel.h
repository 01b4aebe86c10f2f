// SPDX-License-Identifier: MIT
// Runs work on several threads. This is the only interface to TBB's pool.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace kibori {

namespace detail {
// Calls call(context, i) for each i < count, on up to `threads` threads of the pool.
void run_on_pool(int threads, size_t count, void (*call)(void*, size_t), void* context);
}  // namespace detail

// Runs f(0) ... f(count - 1) on up to `threads` threads, and returns when all are done. If threads
// <= 1 or count <= 1, all calls run on the caller's thread, in order and without allocation.
template <class F>
void run_parallel(int threads, size_t count, F&& f) {
  if (threads <= 1 || count <= 1) {
    for (size_t i = 0; i < count; i++) f(i);
    return;
  }
  // Each f sees what the caller wrote before this call. After this call, the caller sees what each
  // f wrote. The pool guarantees this order, but the thread sanitiser cannot see into the pool. The
  // accesses to `order` show the guarantee to the sanitiser.
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

// Calls f(i, thread) once for each i < count. `thread` is a number below max(threads, 1). Calls
// that run at the same time have different numbers. Use this function for many short pieces of work
// that need scratch memory per thread.
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

// Use this function for very short pieces of work. It calls f(first, number) for ranges of `number`
// indices that begin at `first`. Each range has kPieceSize indices; the last one may have fewer.
inline constexpr size_t kPieceSize = 256;
template <class F>
void run_parallel_ranges(int threads, size_t count, F&& f) {
  run_parallel_slices(threads, (count + kPieceSize - 1) / kPieceSize, [&](size_t piece, size_t) {
    const size_t first = piece * kPieceSize;
    f(first, std::min(kPieceSize, count - first));
  });
}

// Like run_parallel_ranges, but calls f(i) for each i < count.
template <class F>
void run_parallel_pieces(int threads, size_t count, F&& f) {
  run_parallel_ranges(threads, count, [&](size_t first, size_t number) {
    for (size_t i = first; i < first + number; i++) f(i);
  });
}

}  // namespace kibori
