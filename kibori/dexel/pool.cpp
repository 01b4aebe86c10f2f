// SPDX-License-Identifier: MIT
#include <kibori/dexel/pool.h>

#include <algorithm>
#include <new>

#include <cstring>
#include <utility>

namespace kibori {
namespace {
constexpr std::align_val_t kAlign{64};
}

BlockPool::BlockPool(size_t bytes, size_t chunk_bytes)
    : bytes_((std::max(bytes, sizeof(Free)) + 63) / 64 * 64), chunk_bytes_(chunk_bytes) {}

BlockPool::~BlockPool() {
  for (void* chunk : chunks_) ::operator delete(chunk, kAlign);
}

void* BlockPool::take() {
  if (!mine_) mine_ = returned_.exchange(nullptr, std::memory_order_acquire);
  while (!mine_) {
    reserve(1);
    mine_ = returned_.exchange(nullptr, std::memory_order_acquire);
  }
  Free* block = mine_;
  mine_ = block->next;
  taken_.store(taken_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  return block;
}

void BlockPool::give(void* block) {
  Free* free = new (block) Free{nullptr};
  give_chain(free, free, 1);
}

void BlockPool::give_chain(Free* first, Free* last, size_t count) {
  Free* head = returned_.load(std::memory_order_relaxed);
  do {
    last->next = head;
  } while (!returned_.compare_exchange_weak(head, first, std::memory_order_release,
                                            std::memory_order_relaxed));
  given_.fetch_add(count, std::memory_order_relaxed);
}

void* BlockPool::take_shared() {
  const std::lock_guard lock(lock_);
  if (!aside_) take_surplus();
  if (!aside_) {
    const size_t count = std::max<size_t>(1, chunk_bytes_ / bytes_);
    aside_ = make(count).first;
    lying_aside_.fetch_add(count, std::memory_order_relaxed);
  }
  lying_aside_.fetch_sub(1, std::memory_order_relaxed);
  return std::exchange(aside_, aside_->next);
}

void BlockPool::take_surplus() {
  // given_ - taken_ counts all ready blocks, in `returned_` and in `mine_`. Only the owner may read
  // `mine_`. So `returned_` may hold fewer blocks than the difference.
  if (given_.load(std::memory_order_relaxed) - taken_.load(std::memory_order_relaxed) <
      2 * kOwnersShare)
    return;
  Free* const first = returned_.exchange(nullptr, std::memory_order_acquire);
  if (!first) return;
  Free* last = first;
  for (size_t left = 1; left < kOwnersShare && last->next; left++) last = last->next;
  aside_ = last->next;
  give_chain(first, last, 0);
  size_t count = 0;
  for (const Free* block = aside_; block; block = block->next) count++;
  given_.fetch_sub(count, std::memory_order_relaxed);
  lying_aside_.fetch_add(count, std::memory_order_relaxed);
}

void BlockPool::give_shared(void* block) {
  const std::lock_guard lock(lock_);
  aside_ = new (block) Free{aside_};
  lying_aside_.fetch_add(1, std::memory_order_relaxed);
}

void BlockPool::reserve(size_t blocks) {
  const std::lock_guard lock(lock_);
  if (Free* const first = aside_) {
    Free* last = first;
    size_t count = 1;
    for (; count < blocks && last->next; count++) last = last->next;
    aside_ = last->next;
    lying_aside_.fetch_sub(count, std::memory_order_relaxed);
    give_chain(first, last, count);
    if (count >= blocks) return;
    blocks -= count;
  }
  const size_t count = std::max(blocks, std::max<size_t>(1, chunk_bytes_ / bytes_));
  const auto [first, last] = make(count);
  give_chain(first, last, count);
}

std::pair<BlockPool::Free*, BlockPool::Free*> BlockPool::make(size_t count) {
  auto* chunk = static_cast<std::byte*>(::operator new(count* bytes_, kAlign));
  // Writes to every memory page now. Otherwise the first use would cause a page fault and delay the
  // servo thread.
  std::memset(chunk, 0, count * bytes_);
  chunks_.push_back(chunk);
  Free* first = nullptr;
  Free* last = nullptr;
  for (size_t i = count; i-- > 0;) {
    first = new (chunk + i * bytes_) Free{first};
    if (!last) last = first;
  }
  made_.fetch_add(count, std::memory_order_relaxed);
  return {first, last};
}

}  // namespace kibori
