// SPDX-License-Identifier: MIT
#include <kibori/devices/dds_device.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <kibori/base/handover.h>
#include <kibori/devices/dds_link.h>

namespace kibori {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kFreshS = 0.002;
// Upper limit of the measured period between poses. A device that sends much more rarely counts as
// stale between two poses. kPeriodFade is the weight of a new value in the mean period.
constexpr double kLongestPeriodS = 0.005, kPeriodFade = 0.05;
// A velocity is computed from two poses whose times differ by at least kBetweenS. With less time
// between them, the clock's error dominates. If the sender's times differ by kTogetherS or more,
// or go back, the times of arrival are used instead.
constexpr double kBetweenS = 0.0009, kTogetherS = 1;

}  // namespace

struct DdsDevice::State {
  struct Timed {
    DeviceReading reading;
    Clock::time_point at;
    double period_s = 0;  // mean time between poses
  };
  DeviceCapabilities capabilities;
  LatestValue<Timed> readings;
  Timed last;
  bool seen = false;

  // For Fast DDS's threads; `mutex` guards these members.
  std::mutex mutex;
  // The last pose from which a velocity was computed.
  std::optional<DeviceReading> last_reading;
  Clock::time_point received_at;
  double period_s = 0;
  int64_t sent_ns = 0;

  LatestValue<Wrench> wrench;
  std::atomic<int> signals{0};
  std::atomic<bool> stopping{false};
  std::unique_ptr<DdsLink> link;  // destroyed before the data that its threads use
  std::thread thread;

  void take(int64_t ns, const Pose& pose) {
    const std::lock_guard<std::mutex> lock(mutex);
    Timed now{{pose.tip, pose.frame}, Clock::now(), 0};
    // Uses the sender's clock if it has one, because late poses arrive in bursts.
    const double reported_s = 1e-9 * static_cast<double>(ns - sent_ns),
                 since = reported_s > 0 && reported_s < kTogetherS
                             ? reported_s
                             : std::chrono::duration<double>(now.at - received_at).count();
    if (last_reading) period_s += kPeriodFade * (std::min(since, kLongestPeriodS) - period_s);
    now.period_s = period_s;
    if (last_reading && since < kBetweenS) {
      now.reading.velocity_mm_s = last_reading->velocity_mm_s;
    } else {
      if (last_reading) now.reading.velocity_mm_s = (pose.tip - last_reading->position_mm) / since;
      last_reading = now.reading;
      received_at = now.at;
      sent_ns = ns;
    }
    readings.put(now);
  }

  void run() {
    while (!stopping.load(std::memory_order_relaxed)) {
      const int heard = signals.load(std::memory_order_acquire);
      Wrench now;
      if (wrench.take(now)) link->write(0, "kibori_device", ns_since_1970(), now);
      if (!stopping) signals.wait(heard, std::memory_order_acquire);
    }
    link->write(0, "kibori_device", ns_since_1970(), Wrench());
  }
  void signal() {
    signals.fetch_add(1, std::memory_order_release);
    signals.notify_one();
  }
};

DdsDevice::DdsDevice(std::unique_ptr<State> state) : state_(std::move(state)) {}

Result<std::unique_ptr<DdsDevice>> DdsDevice::open(uint32_t domain) {
  auto state = std::make_unique<State>();
  Result<std::unique_ptr<DdsLink>> link = DdsLink::open(
      domain, {{},
               {"/kibori/device/wrench"},
               "/kibori/device/pose",
               [state = state.get()](int64_t ns, const Pose& pose) { state->take(ns, pose); }});
  if (!link) return Error{link.error()};
  state->link = std::move(link).value();
  DeviceCapabilities& c = state->capabilities;
  c.name = "a hand behind DDS (domain " + std::to_string(domain) + ")";
  c.dof_in = 6;
  c.dof_out = 6;
  c.torque_nmm = 100;
  state->thread = std::thread([state = state.get()] { state->run(); });
  return std::unique_ptr<DdsDevice>(new DdsDevice(std::move(state)));
}

DdsDevice::~DdsDevice() {
  state_->stopping = true;
  state_->signal();
  state_->thread.join();
}

const DeviceCapabilities& DdsDevice::capabilities() const { return state_->capabilities; }

DeviceStatus DdsDevice::read(DeviceReading& reading) {
  state_->seen |= state_->readings.take(state_->last);
  reading = state_->last.reading;
  if (!state_->seen) return reading.age_s = kUnknownAge, DeviceStatus::stale;
  // Twice the period: a pose that is due may be late by one period.
  reading.age_s =
      std::max(0.0, std::chrono::duration<double>(Clock::now() - state_->last.at).count() -
                        2 * state_->last.period_s);
  return reading.age_s < kFreshS ? DeviceStatus::ok : DeviceStatus::stale;
}

DeviceStatus DdsDevice::write(const Wrench& wrench) {
  state_->wrench.put(wrench);
  state_->signal();
  return DeviceStatus::ok;
}

std::string DdsDevice::complaint() const {
  return state_->seen
             ? std::string()
             : capabilities().name + ": no pose has been received on /kibori/device/pose yet";
}

}  // namespace kibori
