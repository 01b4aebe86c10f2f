// SPDX-License-Identifier: MIT
// From a device's small workspace to the object: scale, offset and a clutch, as one lifts a mouse.
#pragma once

#include <kibori/haptics/device.h>

namespace kibori {

class Workspace {
 public:
  // The device's centre stands at centre_mm; a mm there is `scale` mm here. clutch_button: 0 is the
  // first; negative: none.
  explicit Workspace(const Vec3& centre_mm = Vec3::Zero(), double scale = 1, int clutch_button = -1)
      : centre_mm_(centre_mm), scale_(scale), clutch_button_(clutch_button) {}

  // Where the tool is wanted. While the clutch is held it stays where it was, and goes on from
  // there afterwards; it turns with the hand all the time.
  Pose pose_of(const DeviceReading& reading) {
    const Vec3 there = centre_mm_ + scale_ * reading.position_mm;
    clutched_ = clutch_button_ >= 0 && ((reading.buttons >> clutch_button_) & 1);
    if (clutched_ && started_) {
      centre_mm_ += last_ - there;
    } else {
      last_ = there;
    }
    started_ = true;
    return {last_, reading.frame};
  }
  // The tool is there from now on, as if the clutch had been held on the way.
  void bring(const Vec3& tip_mm) {
    centre_mm_ = started_ ? Vec3(centre_mm_ + tip_mm - last_) : tip_mm;
    last_ = tip_mm;
  }
  // About where the tool is.
  void set_scale(double scale) {
    if (started_) centre_mm_ = last_ - (last_ - centre_mm_) * (scale / scale_);
    scale_ = scale;
  }
  bool clutched() const { return clutched_; }
  double scale() const { return scale_; }

 private:
  Vec3 centre_mm_;
  double scale_;
  int clutch_button_;
  bool clutched_ = false, started_ = false;
  Vec3 last_ = Vec3::Zero();
};

}  // namespace kibori
