// SPDX-License-Identifier: MIT
// A device's readings kept, and played back as a device: to repeat a session without the hand.
//
// Files are CSV, one reading a line: t [s], x y z [mm], the frame's nine numbers row by row,
// buttons.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

struct RecordedReading {
  double time_s = 0;
  Vec3 position_mm = Vec3::Zero();
  Mat3 frame = Mat3::Identity();
  uint32_t buttons = 0;
};

// Errors: what can't be read, with file and line.
Result<std::vector<RecordedReading>> read_recording(const std::filesystem::path& path);

// Passes everything on to the device it wraps, and keeps its readings in memory that was there
// before.
class RecordingDevice final : public Device {
 public:
  // Keeps the first `room` readings.
  RecordingDevice(std::unique_ptr<Device> device, double tick_s, size_t room);
  const DeviceCapabilities& capabilities() const override { return device_->capabilities(); }
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override { return device_->write(wrench); }
  void expect_stiffness(double n_mm) override { device_->expect_stiffness(n_mm); }
  std::string complaint() const override { return device_->complaint(); }
  const std::vector<RecordedReading>& readings() const { return readings_; }
  // Readings there was no room for.
  uint64_t left_out() const { return left_out_; }
  // Errors: those of writing files.
  Status save(const std::filesystem::path& path) const;

 private:
  std::unique_ptr<Device> device_;
  double tick_s_, time_s_ = 0;
  std::vector<RecordedReading> readings_;
  uint64_t left_out_ = 0;
};

// Plays readings, one a read; stays at the last. Forces go nowhere.
class ReplayDevice final : public Device {
 public:
  // At least one reading.
  ReplayDevice(std::vector<RecordedReading> readings, const DeviceCapabilities& capabilities);
  const DeviceCapabilities& capabilities() const override { return capabilities_; }
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench&) override { return DeviceStatus::ok; }
  bool finished() const { return next_ >= readings_.size(); }

 private:
  std::vector<RecordedReading> readings_;
  DeviceCapabilities capabilities_;
  size_t next_ = 0;
};

}  // namespace kibori
