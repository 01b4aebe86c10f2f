// SPDX-License-Identifier: MIT
// Clock of the servo loop: wakes at every period of an absolute clock and keeps statistics. It
// sleeps between ticks and never spins, because the system throttles a busy real-time thread.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/haptics/histogram.h>

namespace kibori {

struct ServoStatistics {
  Histogram period_ns;   // from tick to tick
  Histogram compute_ns;  // work of a tick
  Histogram late_ns;     // start of a tick minus its due time
  uint64_t ticks = 0;
  uint64_t missed = 0;  // periods in which no tick began
  double seconds = 0;
};

// Requests SCHED_FIFO and locked memory for the calling thread. Returns one sentence that says what
// the system permitted.
std::string enter_real_time();

// Time between ticks [ns]. The rate must be 1 ... 4000 Hz.
int64_t period_of(double rate_hz);

// Clock of one thread. Usage: while (...) { clock.wait(); ...tick...; clock.done(); }
class ServoClock {
 public:
  explicit ServoClock(double rate_hz);
  // Sleeps until the next tick is due. Skips ticks that it has missed. Returns the seconds since
  // the last tick began (0 the first time).
  double wait();
  // Call this when the work of the tick is done.
  void done();
  const ServoStatistics& statistics() const { return statistics_; }

 private:
  const int64_t period_ns_;
  int64_t start_ns_ = 0, due_ns_ = 0, began_ns_ = 0;
  ServoStatistics statistics_;
};

}  // namespace kibori
