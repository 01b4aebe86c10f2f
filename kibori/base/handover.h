// SPDX-License-Identifier: MIT
// Passes data from a writer thread to a reader thread without a lock. LatestValue passes the newest
// value. SmallQueue passes a few items in order. Each object has one writer and one reader.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace kibori {

// The reader gets the newest value. If the writer puts two values before the reader takes one, the
// older value is lost. There are three slots: the writer's (mine_), the reader's (theirs_), and one
// between them (between_). put() and take() exchange their slot with the one between.
template <class T>
class LatestValue {
 public:
  // Only the writer thread may call this.
  void put(T value) {
    places_[mine_] = std::move(value);
    mine_ =
        between_.exchange(static_cast<uint8_t>(mine_ | kNew), std::memory_order_acq_rel) & kPlace;
    // If the reader did not take the previous value, that value is now in `mine_`. The next put()
    // overwrites it.
  }
  // Only the reader thread may call this. If there is a new value, moves it to `value` and returns
  // true.
  bool take(T& value) {
    if (!(between_.load(std::memory_order_relaxed) & kNew)) return false;
    theirs_ = between_.exchange(theirs_, std::memory_order_acq_rel) & kPlace;
    value = std::move(places_[theirs_]);
    places_[theirs_] = T();
    return true;
  }

 private:
  static constexpr uint8_t kPlace = 3, kNew = 4;
  std::array<T, 3> places_{};
  std::atomic<uint8_t> between_{1};
  uint8_t mine_ = 0, theirs_ = 2;
};

// A queue of up to kRoom items.
template <class T, size_t kRoom = 64>
class SmallQueue {
 public:
  // Only the writer thread may call this. Returns false if the queue is full.
  bool push(T value) {
    if (full()) return false;
    const size_t end = end_.load(std::memory_order_relaxed);
    places_[end % kRoom] = std::move(value);
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  // Only the writer thread may call this. Returns true if push() would return false.
  bool full() const {
    return end_.load(std::memory_order_relaxed) - begin_.load(std::memory_order_acquire) == kRoom;
  }
  // Only the reader thread may call this.
  bool empty() const {
    return begin_.load(std::memory_order_relaxed) == end_.load(std::memory_order_acquire);
  }
  // Only the reader thread may call this. Returns the item that pop() would return, or null if the
  // queue is empty.
  const T* front() const {
    return empty() ? nullptr : &places_[begin_.load(std::memory_order_relaxed) % kRoom];
  }
  // Only the reader thread may call this. Moves the oldest item to `value`. Returns false if the
  // queue is empty.
  bool pop(T& value) {
    const size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    value = std::move(places_[begin % kRoom]);
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, kRoom> places_{};
  std::atomic<size_t> begin_{0}, end_{0};
};

}  // namespace kibori
