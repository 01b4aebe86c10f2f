// SPDX-License-Identifier: MIT
// Passes data between two threads without a lock: the newest value (LatestValue), or a few items in
// order (SmallQueue).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace kibori {

// One writer, one reader. The reader gets the newest value; older ones are lost. There are three
// slots: the writer's, the reader's, and one between them that they exchange.
template <class T>
class LatestValue {
 public:
  // Writer.
  void put(T value) {
    places_[mine_] = std::move(value);
    mine_ =
        between_.exchange(static_cast<uint8_t>(mine_ | kNew), std::memory_order_acq_rel) & kPlace;
    // A value that was not read in time is now in `mine_`. The next put overwrites it.
  }
  // Reader. Returns true if there was a new value, and moves it to `value`.
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

// One writer, one reader, in order. Full at kRoom items.
template <class T, size_t kRoom = 64>
class SmallQueue {
 public:
  // Writer. Returns false if the queue is full.
  bool push(T value) {
    if (full()) return false;
    const size_t end = end_.load(std::memory_order_relaxed);
    places_[end % kRoom] = std::move(value);
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  // Writer. True if push() would return false.
  bool full() const {
    return end_.load(std::memory_order_relaxed) - begin_.load(std::memory_order_acquire) == kRoom;
  }
  // Reader.
  bool empty() const {
    return begin_.load(std::memory_order_relaxed) == end_.load(std::memory_order_acquire);
  }
  // Reader. The item that pop() will return; null if the queue is empty.
  const T* front() const {
    return empty() ? nullptr : &places_[begin_.load(std::memory_order_relaxed) % kRoom];
  }
  // Reader. Returns false if the queue is empty.
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
