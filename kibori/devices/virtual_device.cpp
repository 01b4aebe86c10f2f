// SPDX-License-Identifier: MIT
#include <kibori/devices/virtual_device.h>

#include <algorithm>
#include <cmath>

namespace kibori {

VirtualDevice::VirtualDevice(const VirtualDeviceSettings& settings, Script script)
    : settings_(settings),
      script_(std::move(script)),
      hand_(settings.hand, script_(0).position_mm) {
  settings_.delay_ticks = std::clamp(settings.delay_ticks, 0, kMaxDelay);
  forces_.fill(Vec3::Zero());
}

DeviceStatus VirtualDevice::read(DeviceReading& reading) {
  if (status_ == DeviceStatus::unplugged || status_ == DeviceStatus::failed) return status_;
  const double T = settings_.tick_s;
  if (started_) {
    time_s_ += T;
    const Target next = script_(time_s_);
    const Vec3 velocity = (next.position_mm - target_.position_mm) / T;
    hand_.step(forces_[static_cast<size_t>(settings_.delay_ticks)], next.position_mm, velocity, T);
    std::shift_right(forces_.begin(), forces_.end(), 1);
    forces_[0] = forces_[1];  // the last force acts until the next write
    target_ = next;
  } else {
    target_ = script_(0);
  }
  if (status_ == DeviceStatus::stale) {
    reading.age_s += T;
    return status_;
  }
  reading.position_mm = hand_.position_mm();
  if (settings_.count_mm > 0)
    for (int i = 0; i < 3; i++)
      reading.position_mm[i] =
          std::round(reading.position_mm[i] / settings_.count_mm) * settings_.count_mm;
  reading.velocity_mm_s =
      started_ ? Vec3((reading.position_mm - last_read_) / T) : Vec3(Vec3::Zero());
  reading.frame = target_.frame;
  reading.buttons = target_.buttons;
  reading.age_s = 0;
  last_read_ = reading.position_mm;
  started_ = true;
  return DeviceStatus::ok;
}

DeviceStatus VirtualDevice::write(const Wrench& wrench) {
  if (status_ == DeviceStatus::unplugged || status_ == DeviceStatus::failed) return status_;
  forces_[0] = wrench.force;
  return DeviceStatus::ok;
}

std::string VirtualDevice::complaint() const {
  switch (status_) {
    case DeviceStatus::ok:
      return {};
    case DeviceStatus::stale:
      return "the virtual device has no new reading";
    case DeviceStatus::unplugged:
      return "the virtual device was unplugged";
    case DeviceStatus::failed:
      return "the virtual device failed";
  }
  return {};
}

}  // namespace kibori
