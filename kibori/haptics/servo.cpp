// SPDX-License-Identifier: MIT
#include <kibori/haptics/servo.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <kibori/base/check.h>

namespace kibori {
namespace {

constexpr int64_t kSecond = 1'000'000'000;
constexpr int kPriority = 80;  // above ordinary threads and most interrupts, below the kernel's own

int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

}  // namespace

std::string enter_real_time() {
  sched_param priority{};
  priority.sched_priority = kPriority;
  const int scheduling = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
  const bool locked = mlockall(MCL_CURRENT) == 0;
  std::string text =
      scheduling == 0
          ? "real-time scheduling (SCHED_FIFO)"
          : std::string("ordinary scheduling (the system refused real-time scheduling: ") +
                std::strerror(scheduling) + "; allow it with rtprio in limits.conf)";
  text += locked ? ", memory locked" : ", memory not locked (raise memlock in limits.conf)";
  return text;
}

int64_t period_of(double rate_hz) {
  KIBORI_CHECK(rate_hz >= 1 && rate_hz <= 4000);
  return std::llround(static_cast<double>(kSecond) / rate_hz);
}

ServoClock::ServoClock(double rate_hz) : period_ns_(period_of(rate_hz)) {}

double ServoClock::wait() {
  if (statistics_.ticks == 0) {
    start_ns_ = due_ns_ = began_ns_ = now_ns();
    statistics_.ticks = 1;
    return 0;
  }
  due_ns_ += period_ns_;
  int64_t now = now_ns();
  if (now >= due_ns_ + period_ns_) {
    // Skips the ticks that should already have ended.
    const int64_t past = (now - due_ns_) / period_ns_;
    statistics_.missed += static_cast<uint64_t>(past);
    due_ns_ += past * period_ns_;
  }
  while (now < due_ns_) {
    const timespec until{due_ns_ / kSecond, due_ns_ % kSecond};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    now = now_ns();
  }
  if (now >= due_ns_ + period_ns_) {
    const int64_t past = (now - due_ns_) / period_ns_;
    statistics_.missed += static_cast<uint64_t>(past);
    statistics_.late_ns.add(now - due_ns_);
    due_ns_ += past * period_ns_;
  } else {
    statistics_.late_ns.add(now - due_ns_);
  }
  const int64_t since = now - began_ns_;
  statistics_.period_ns.add(since);
  statistics_.ticks++;
  began_ns_ = now;
  return 1e-9 * static_cast<double>(since);
}

void ServoClock::done() {
  const int64_t now = now_ns();
  statistics_.compute_ns.add(now - began_ns_);
  statistics_.seconds = 1e-9 * static_cast<double>(now - start_ns_);
}

}  // namespace kibori
