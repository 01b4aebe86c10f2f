// SPDX-License-Identifier: MIT
// Memory pool of blocks for tiles, pages and roots. With it, an edit on the servo thread does not
// allocate or free memory.
//
//   owner (the writer)          any thread
//   take() <── mine ◄──exchange── returned ◄── give()
//                                    ▲ reserve()
//   take_shared() <───────────────── aside ◄── give_shared()      under a lock
//
// The owner takes blocks; any thread gives them back. The owner takes the whole returned list at
// once, so there is no ABA problem. A second writer takes blocks from `aside` and returns them
// there. If `aside` is empty, it takes returned blocks, but leaves kOwnersShare of them to the
// owner. Otherwise all blocks that snapshots release would collect at the owner. The second writer
// would always need new ones.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

namespace kibori {

class BlockPool {
 public:
  // Blocks of `bytes` bytes, 64-byte aligned. The pool allocates about `chunk_bytes` at a time.
  explicit BlockPool(size_t bytes, size_t chunk_bytes = size_t{1} << 20);
  ~BlockPool();
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // Uninitialised memory. Owner thread only. Allocates only if the pool is empty.
  void* take();
  // Any thread. It retries only if another thread changes the returned list at the same time.
  void give(void* block);
  // Number of ready blocks that a second writer leaves to the owner.
  static constexpr size_t kOwnersShare = 4096;
  // The same as take() and give() for any thread, under a lock.
  void* take_shared();
  void give_shared(void* block);
  // Makes at least `blocks` more blocks ready. Uses those in `aside` first. Any thread.
  void reserve(size_t blocks);
  // Makes blocks ready for take() until at least `blocks` are ready. Any thread.
  void keep_ready(size_t blocks) {
    const size_t ready =
        given_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed);
    if (ready < blocks) reserve(blocks - ready);
  }

  // Size of all blocks that were taken and not given back. Any thread.
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
  // Moves returned blocks beyond kOwnersShare to `aside`. Call under the lock.
  void take_surplus();
  // A chain of new blocks: its first and last. Call under the lock.
  std::pair<Free*, Free*> make(size_t count);

  const size_t bytes_;
  const size_t chunk_bytes_;
  // given_ includes new blocks that reserve() made ready. taken_ counts only take().
  std::atomic<size_t> made_{0}, given_{0}, taken_{0}, lying_aside_{0};
  Free* mine_ = nullptr;
  std::atomic<Free*> returned_{nullptr};
  std::mutex lock_;  // protects the members below
  Free* aside_ = nullptr;
  std::vector<void*> chunks_;
};

}  // namespace kibori
