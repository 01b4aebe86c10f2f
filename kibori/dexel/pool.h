// SPDX-License-Identifier: MIT
// A memory pool of blocks for tiles, planes, pages and roots. With it, an edit on the servo thread
// neither allocates nor frees memory.
//
//   owner (the writer)          any thread
//   take() <── mine ◄──exchange── returned ◄── give()
//                                    ▲ reserve()
//   take_shared() <───────────────── aside ◄── give_shared()      under a lock
//
// The owner is the field's first writer. It takes blocks, and any thread gives them back. The owner
// takes the whole returned list at once, so there is no ABA problem. A second writer takes blocks
// from `aside` and gives them back there. If `aside` is empty and many returned blocks are ready,
// the second writer takes them, but leaves kOwnersShare of them to the owner. Without this rule,
// all blocks that snapshots release would collect at the owner, and the second writer would always
// need new ones.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

namespace kibori {

class BlockPool {
 public:
  // Makes a pool of blocks of `bytes` bytes, aligned to 64 bytes. It allocates about `chunk_bytes`
  // at a time.
  explicit BlockPool(size_t bytes, size_t chunk_bytes = size_t{1} << 20);
  ~BlockPool();
  BlockPool(const BlockPool&) = delete;
  BlockPool& operator=(const BlockPool&) = delete;

  // Returns an uninitialised block. Only the owner's thread may call this. It allocates only if the
  // pool is empty.
  void* take();
  // Gives a block back. Any thread. It repeats its write only if another thread changes the
  // returned list at the same time.
  void give(void* block);
  // Number of ready blocks that a second writer leaves to the owner.
  static constexpr size_t kOwnersShare = 4096;
  // take() and give() for second writers. Any thread; both use a lock.
  void* take_shared();
  void give_shared(void* block);
  // Makes at least `blocks` more blocks ready for take(). Uses the blocks in `aside` before it
  // allocates. Any thread.
  void reserve(size_t blocks);
  // Makes blocks ready for take(), until at least `blocks` of them are ready. Any thread.
  void keep_ready(size_t blocks) {
    const size_t ready =
        given_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed);
    if (ready < blocks) reserve(blocks - ready);
  }

  // Size of all blocks that were taken and not given back [bytes]. Any thread.
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
  // If at least 2 kOwnersShare blocks are ready, moves returned blocks to `aside`. kOwnersShare of
  // them stay. Call it under the lock.
  void take_surplus();
  // Allocates a chain of new blocks. Returns its first and its last block. Call it under the lock.
  std::pair<Free*, Free*> make(size_t count);

  const size_t bytes_;
  const size_t chunk_bytes_;
  // Numbers of blocks: allocated, made ready for take(), taken by take(), and in `aside`. A block
  // counts as made ready when give() returns it or reserve() provides it.
  std::atomic<size_t> made_{0}, given_{0}, taken_{0}, lying_aside_{0};
  Free* mine_ = nullptr;
  std::atomic<Free*> returned_{nullptr};
  std::mutex lock_;  // protects the members below
  Free* aside_ = nullptr;
  std::vector<void*> chunks_;
};

}  // namespace kibori
