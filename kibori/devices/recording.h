// SPDX-License-Identifier: MIT
// Records the readings of a device, and replays them as a device. So a session can be repeated
// without a hand.
//
// A recording is a CSV file with a heading. Each line has one reading: t [s], x y z [mm], the nine
// numbers of the frame row by row, buttons.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

// One reading of a device, with the time since the start.
struct RecordedReading {
  double time_s = 0;
  Vec3 position_mm = Vec3::Zero();
  Mat3 frame = Mat3::Identity();
  uint32_t buttons = 0;
};

// Reads a recording. Errors: the file cannot be read or has no readings; a line is invalid. The
// message names file and line.
Result<std::vector<RecordedReading>> read_recording(const std::filesystem::path& path);

// Forwards all calls to another device, and stores its readings.
class RecordingDevice final : public Device {
 public:
  // Keeps the first `room` readings, in memory that is reserved here. A read() counts as `tick_s`.
  RecordingDevice(std::unique_ptr<Device> device, double tick_s, size_t room);
  const DeviceCapabilities& capabilities() const override { return device_->capabilities(); }
  DeviceStatus read(DeviceReading& reading) override;
  DeviceStatus write(const Wrench& wrench) override { return device_->write(wrench); }
  void expect_stiffness(double n_mm) override { device_->expect_stiffness(n_mm); }
  std::string complaint() const override { return device_->complaint(); }
  const std::vector<RecordedReading>& readings() const { return readings_; }
  // Returns the number of readings for which there was no room.
  uint64_t left_out() const { return left_out_; }
  // Writes a recording. Errors: the file cannot be written.
  Status save(const std::filesystem::path& path) const;

 private:
  std::unique_ptr<Device> device_;
  double tick_s_, time_s_ = 0;
  std::vector<RecordedReading> readings_;
  uint64_t left_out_ = 0;
};

// Replays readings, one per read(). After the last reading, it repeats this reading. Ignores
// forces.
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
