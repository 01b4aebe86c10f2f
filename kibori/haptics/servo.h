// SPDX-License-Identifier: MIT
// The loop that keeps time: wakes at every period of an absolute clock, runs one tick, and keeps
// statistics. It sleeps between ticks and never spins: a busy real-time thread is throttled by the
// system.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/haptics/histogram.h>

namespace kibori {

struct ServoStatistics {
  Histogram period_ns;   // from tick to tick
  Histogram compute_ns;  // a tick's work
  Histogram late_ns;     // from when a tick was due to when it began
  uint64_t ticks = 0;
  uint64_t missed = 0;  // periods in which no tick began
  double seconds = 0;
};

// Asks for SCHED_FIFO and locked memory for the calling thread and says in one sentence what was
// permitted.
std::string enter_real_time();

// The time between ticks [ns] of a rate; rates are 1 ... 4000 Hz.
int64_t period_of(double rate_hz);

// One thread's clock. Usage: while (...) { clock.wait(); ...tick...; clock.done(); }
class ServoClock {
 public:
  explicit ServoClock(double rate_hz);
  // Sleeps until the next tick is due, skipping those that are past; returns the seconds since the
  // last one began (0 the first time).
  double wait();
  void done();
  const ServoStatistics& statistics() const { return statistics_; }

 private:
  const int64_t period_ns_;
  int64_t start_ns_ = 0, due_ns_ = 0, began_ns_ = 0;
  ServoStatistics statistics_;
};

}  // namespace kibori
