// SPDX-License-Identifier: MIT
// A mouse, a pen or a finger on glass: someone else says where the hand wants to be, some sixty times a
// second, and nothing pushes back. What is read in between goes there smoothly.
#pragma once

#include <kibori/base/handover.h>
#include <kibori/haptics/device.h>

namespace kibori {

class PointerDevice final : public Device {
 public:
  explicit PointerDevice(double rate_hz);

  // Where the hand is wanted from now on [mm]; `at_once`: it is there, and took no way. One thread.
  void aim(const Vec3& position_mm, const Mat3& frame, bool at_once);

  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  // Nothing before the first aim().
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench&) override { return DeviceStatus::ok; }

 private:
  struct Target {
    Vec3 position_mm = Vec3::Zero();
    Mat3 frame = Mat3::Identity();
    // The last place taken at once, and how many there were: so that none is lost to the next target.
    Vec3 jump_mm = Vec3::Zero();
    Mat3 jump_frame = Mat3::Identity();
    uint64_t jumps = 0;
  };

  DeviceCapabilities capabilities_;
  const double tick_s_;
  LatestValue<Target> aimed_;
  Target last_;  // of the one who aims
  // Of the servo thread.
  Target target_;
  bool there_ = false;
  uint64_t jumped_ = 0;
  DeviceReading now_;
};

}  // namespace kibori
