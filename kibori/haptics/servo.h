// SPDX-License-Identifier: MIT
// The clock of the servo loop. It wakes a thread in every period of an absolute clock, and keeps
// statistics. Between ticks, the thread sleeps. It does not poll the time, because the system
// throttles a real-time thread that never sleeps.
#pragma once

#include <cstdint>
#include <string>

#include <kibori/haptics/histogram.h>

namespace kibori {

struct ServoStatistics {
  Histogram period_ns;   // time from the start of a tick to the start of the next
  Histogram compute_ns;  // duration of a tick's work
  Histogram late_ns;     // start of a tick minus its due time
  uint64_t ticks = 0;
  uint64_t missed = 0;  // periods in which no tick began
  double seconds = 0;
};

// Requests SCHED_FIFO and locked memory for the calling thread. Returns a text for the user: what
// the system permitted.
std::string enter_real_time();

// Returns the time between ticks [ns]. The rate must be 1 ... 4000 Hz.
int64_t period_of(double rate_hz);

// The clock of one thread. Usage: while (...) { clock.wait(); ...tick...; clock.done(); }
class ServoClock {
 public:
  explicit ServoClock(double rate_hz);
  // Sleeps until the next tick is due. Skips ticks that are already over. Returns the time since
  // the last tick began [s], or 0 at the first call.
  double wait();
  // Call this at the end of a tick's work.
  void done();
  const ServoStatistics& statistics() const { return statistics_; }

 private:
  const int64_t period_ns_;
  int64_t start_ns_ = 0, due_ns_ = 0, began_ns_ = 0;
  ServoStatistics statistics_;
};

}  // namespace kibori
