// SPDX-License-Identifier: MIT
#include <kibori/devices/pointer_device.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// Speed of the hand from a clear position of the tool to a stroke's first point. It is 0.25 mm per
// tick at 1000 Hz. With a higher speed, the force of the plunge is a mean over a longer distance.
constexpr double kPlungeMmS = 250;
// Maximum angular speed of the hand. The surface's normal, and so a pointer's pose, jumps at an
// edge, but a hand does not. A faster turn is divided into more readings. At 1000 readings per
// second on the studio's finest lattice, a tool of 25 mm then needs about 20 substeps per tick.
constexpr double kFastestTurn = 8;  // rad/s
// If more than kRestS passes between two events, the pointer has rested. The motion to the next
// point then takes only kAfterRestS. kRestS is longer than the event period of the slowest screens
// (30 Hz), so that no motion counts as a rest.
constexpr double kRestS = 0.1, kAfterRestS = 0.016;
// If the hand is farther than this behind the newest event, a tick takes more readings. So the
// picture does not trail the pointer.
constexpr double kBehindS = 0.03;

}  // namespace

PointerDevice::PointerDevice(double rate_hz) : tick_s_(1 / rate_hz) {
  capabilities_.name = "a pointer";
  capabilities_.dof_in = 6;
  capabilities_.dof_out = 0;
  // No force reaches a hand, so these limits only bound the force that is shown.
  capabilities_.force_n = 1000;
  capabilities_.torque_nmm = 1e5;
  capabilities_.force_rate_n_s = 1e7;
  capabilities_.torque_rate_nmm_s = 1e9;
  capabilities_.damping_ns_mm = 1000;
  capabilities_.speed_mm_s = 1e6;  // a path is followed at any speed
  capabilities_.stiffness_n_mm = 0.5;
}

// ---- The thread that aims

void PointerDevice::hover(const Pose& pose) { hovers_.put(pose); }

uint32_t PointerDevice::begin(const Pose& pose, double time_s, double pressure) {
  newest_ = {newest_.stroke + 1, time_s, pose, false, pressure};
  queue(newest_);
  return newest_.stroke;
}

void PointerDevice::move(const Pose& pose, double time_s, double pressure) {
  newest_.pose = pose;
  newest_.pressure = pressure;
  newest_.time_s = std::max(newest_.time_s, time_s);
  queue(newest_);
}

void PointerDevice::end() {
  Event last = newest_;
  last.last = true;
  queue(last);
}

void PointerDevice::queue(const Event& event) {
  waiting_.push_back(event);
  pump();
}

void PointerDevice::pump() {
  while (!waiting_.empty() && events_.push(waiting_.front())) {
    newest_s_.store(waiting_.front().time_s, std::memory_order_relaxed);
    waiting_.pop_front();
  }
}

// ---- The servo thread

void PointerDevice::follow(uint32_t stroke, const Pose& from) {
  stroke_ = stroke;
  began_ = ended_ = false;
  there_ = true;
  now_ = from;
  readings_ = read_ = 0;
}

void PointerDevice::give_up(uint32_t stroke) {
  if (stroke_ <= stroke) stroke_ = 0;
  if (finished_.load(std::memory_order_relaxed) < stroke)
    finished_.store(stroke, std::memory_order_release);
}

void PointerDevice::lead_to(const Event& event, double seconds) {
  from_ = now_;
  to_ = event.pose;
  from_pressure_ = pressure_;
  to_pressure_ = event.pressure;
  turn_rad_ = rotation_between(now_.frame, to_.frame);
  const double turning_s = std::sqrt(turn_rad_.squaredNorm()) / kFastestTurn;
  readings_ = std::max<int64_t>(1, std::llround(std::max(seconds, turning_s) / tick_s_));
  read_ = 0;
}

// Moves on to the next point of the path. Returns false if it is unknown.
bool PointerDevice::next() {
  while (!ended_) {
    if (!has_event_ && !events_.pop(event_)) return false;
    has_event_ = event_.stroke > stroke_;  // the event is kept until its stroke is followed
    if (has_event_) return false;
    if (event_.stroke < stroke_) continue;
    if (event_.last) {
      ended_ = true;
      finished_.store(stroke_, std::memory_order_release);
      return false;
    }
    if (!began_) {
      began_ = true;
      from_s_ = to_s_ = event_.time_s;
      pressure_ = event_.pressure;
      lead_to(event_, std::sqrt((event_.pose.tip - now_.tip).squaredNorm()) / kPlungeMmS);
      return true;
    }
    from_s_ = to_s_;
    to_s_ = event_.time_s;
    const double seconds = to_s_ - from_s_;
    lead_to(event_, seconds > kRestS ? kAfterRestS : seconds);
    return true;
  }
  return false;
}

bool PointerDevice::behind() const {
  if (stroke_ == 0 || ended_ || !began_) return false;
  const double share =
      readings_ > 0 ? static_cast<double>(read_) / static_cast<double>(readings_) : 1;
  return newest_s_.load(std::memory_order_relaxed) - (from_s_ + share * (to_s_ - from_s_)) >
         kBehindS;
}

DeviceStatus PointerDevice::read(DeviceReading& reading) {
  if (stroke_ == 0) {
    there_ |= hovers_.take(now_);
    if (!there_) return DeviceStatus::stale;
  } else if (read_ < readings_ || next()) {
    read_++;
    const double share = static_cast<double>(read_) / static_cast<double>(readings_);
    now_ = read_ == readings_ ? to_
                              : Pose{from_.tip + share * (to_.tip - from_.tip),
                                     rotation(Vec3(share * turn_rad_)) * from_.frame};
    pressure_ = read_ == readings_ ? to_pressure_
                                   : from_pressure_ + share * (to_pressure_ - from_pressure_);
  }
  reading.position_mm = now_.tip;
  reading.frame = now_.frame;
  reading.pressure = pressure_;
  return DeviceStatus::ok;
}

}  // namespace kibori
