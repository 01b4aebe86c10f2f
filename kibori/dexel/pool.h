// SPDX-License-Identifier: MIT
// Blocks for tiles, pages and roots, so that an edit on the servo path allocates and frees nothing.
//
//   owner (the writer)          any thread
//   take() <── mine ◄──exchange── returned ◄── give()
//                                    ▲ reserve()
//   take_shared() <───────────────── aside ◄── give_shared()      under a lock
//
// One thread takes; any thread gives back. The owner grabs the whole returned list at once, so
// there is no ABA. A second writer, which makes states of the model, takes blocks from `aside` and
// returns them there; where none lie aside, it grabs what was returned, and leaves the owner
// kOwnersShare of it: else blocks that it fills and the owner lets go of would pile up.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

namespace kibori {

class BlockPool {
 public:
  // Blocks of `bytes` bytes, 64-byte aligned; the system is asked for about `chunk_bytes` at a
  // time.
  explicit BlockPool(size_t bytes, size_t chunk_bytes = size_t{1} << 20);
  ~BlockPool();
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // Uninitialised memory. Owner thread only. Allocates only when the pool is dry.
  void* take();
  // Any thread; wait-free but for other givers.
  void give(void* block);
  // Blocks ready for the owner that a second writer leaves alone.
  static constexpr size_t kOwnersShare = 4096;
  // As take() and give(), any thread, under a lock.
  void* take_shared();
  void give_shared(void* block);
  // Makes at least `blocks` more blocks ready: those that lie aside first. Any thread.
  void reserve(size_t blocks);
  // Makes as many more as it takes for `blocks` to be ready. Any thread.
  void keep_ready(size_t blocks) {
    const size_t ready =
        given_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed);
    if (ready < blocks) reserve(blocks - ready);
  }

  // Of the blocks that were taken and not given back. Any thread.
  size_t bytes_in_use() const {
    return bytes_ *
           (made_.load(std::memory_order_relaxed) + taken_.load(std::memory_order_relaxed) -
            given_.load(std::memory_order_relaxed) - lying_aside_.load(std::memory_order_relaxed));
  }

 private:
  struct Free {
    Free* next;
  };
  void give_chain(Free* first, Free* last, size_t count);
  // What the owner has more than it needs, aside. Under the lock.
  void take_surplus();
  // A chain of new blocks: its first and last. Under the lock.
  std::pair<Free*, Free*> make(size_t count);

  const size_t bytes_;
  const size_t chunk_bytes_;
  // given_: what was made ready, too; taken_: by the owner alone.
  std::atomic<size_t> made_{0}, given_{0}, taken_{0}, lying_aside_{0};
  Free* mine_ = nullptr;
  std::atomic<Free*> returned_{nullptr};
  std::mutex lock_;  // of what follows
  Free* aside_ = nullptr;
  std::vector<void*> chunks_;
};

}  // namespace kibori
