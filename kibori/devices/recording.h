// SPDX-License-Identifier: MIT
// Records a device's readings, and replays them as a device. Therefore, a session can be repeated
// without a hand.
//
// Files are CSV, one reading per line: t [s], x y z [mm], the frame's nine numbers row by row,
// buttons.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

// One reading of a device, with its time since the start.
struct RecordedReading {
  double time_s = 0;
  Vec3 position_mm = Vec3::Zero();
  Mat3 frame = Mat3::Identity();
  uint32_t buttons = 0;
};

// Errors: an unreadable file or line, with file and line.
Result<std::vector<RecordedReading>> read_recording(const std::filesystem::path& path);

// Forwards all calls to the wrapped device, and stores its readings in memory that the constructor
// reserves.
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
  // Number of readings that did not fit.
  uint64_t left_out() const { return left_out_; }
  // Errors: those of writing a file.
  Status save(const std::filesystem::path& path) const;

 private:
  std::unique_ptr<Device> device_;
  double tick_s_, time_s_ = 0;
  std::vector<RecordedReading> readings_;
  uint64_t left_out_ = 0;
};

// Replays readings, one per read(). Repeats the last one when it has finished. Ignores forces.
class ReplayDevice final : public Device {
 public:
  // `readings` must not be empty.
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
