// SPDX-License-Identifier: MIT
// Maps the small workspace of a device to the model, by a scale, an offset and a clutch. The clutch
// is a button that works like lifting a mouse.
#pragma once

#include <kibori/haptics/device.h>

namespace kibori {

class Workspace {
 public:
  // Maps the device's centre to centre_mm, and 1 mm at the device to `scale` mm. clutch_button: 0
  // is the first button; negative: there is no clutch.
  explicit Workspace(const Vec3& centre_mm = Vec3::Zero(), double scale = 1, int clutch_button = -1)
      : centre_mm_(centre_mm), scale_(scale), clutch_button_(clutch_button) {}

  // Returns the pose that the hand requests for the tool. While the clutch is held, the tip stays
  // in place. After that, it continues from there. The tool always turns with the hand.
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
  // Moves the tool to `tip_mm` without a motion of the hand. Only the offset changes.
  void bring(const Vec3& tip_mm) {
    centre_mm_ = started_ ? Vec3(centre_mm_ + tip_mm - last_) : tip_mm;
    last_ = tip_mm;
  }
  // Changes the scale. The tool stays in place.
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
