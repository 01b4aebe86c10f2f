// SPDX-License-Identifier: MIT
#include <kibori/devices/recording.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <kibori/base/check.h>
#include <kibori/base/file.h>

namespace kibori {
namespace {

constexpr size_t kNumbers = 14;
constexpr const char* kHeading = "t_s,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,buttons\n";

}  // namespace

Result<std::vector<RecordedReading>> read_recording(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path);
  if (!bytes) return Error{bytes.error()};
  const std::string text(bytes.value().begin(), bytes.value().end());
  std::vector<RecordedReading> readings;
  const char* p = text.c_str();
  for (int line = 1; *p; line++) {
    const char* end = p;
    while (*end && *end != '\n') end++;
    const auto wrong = [&](const char* what) {
      return Error{path.string() + ":" + std::to_string(line) + ": " + what};
    };
    if (line == 1) {
      if (text.rfind(kHeading, 0) != 0)
        return wrong("a recording begins with the heading t_s,x_mm,...");
      p = end;
    } else {
      double v[kNumbers];
      for (size_t i = 0; i < kNumbers; i++) {
        char* after = nullptr;
        v[i] = std::strtod(p, &after);
        if (after == p || after > end || !std::isfinite(v[i]))
          return wrong("a line of a recording must have 14 numbers");
        p = after;
        if (i + 1 < kNumbers && *p++ != ',')
          return wrong("a line of a recording must have 14 numbers");
      }
      if (p != end && !(p + 1 == end && *p == '\r'))
        return wrong("a line of a recording must have 14 numbers");
      if (!(v[13] >= 0 && v[13] <= 4294967295.0)) return wrong("buttons must be 0 to 4294967295");
      RecordedReading r;
      r.time_s = v[0];
      r.position_mm = {v[1], v[2], v[3]};
      for (int i = 0; i < 9; i++) r.frame(i / 3, i % 3) = v[4 + i];
      if (!((r.frame * r.frame.transpose() - Mat3::Identity()).norm() < 1e-3 &&
            r.frame.determinant() > 0))
        return wrong("the nine numbers of the frame must be a rotation");
      r.buttons = static_cast<uint32_t>(v[13]);
      readings.push_back(r);
    }
    p = *end ? end + 1 : end;
  }
  if (p != text.c_str() + text.size()) return Error{path.string() + ": is not a text file"};
  if (readings.empty()) return Error{path.string() + ": contains no readings"};
  return readings;
}

RecordingDevice::RecordingDevice(std::unique_ptr<Device> device, double tick_s, size_t room)
    : device_(std::move(device)), tick_s_(tick_s) {
  readings_.reserve(room);
}

DeviceStatus RecordingDevice::read(DeviceReading& reading) {
  const DeviceStatus status = device_->read(reading);
  // Also stores stale readings: with one reading per tick, a replay has the same timing.
  if (status == DeviceStatus::ok || status == DeviceStatus::stale) {
    if (readings_.size() < readings_.capacity())
      readings_.push_back({time_s_, reading.position_mm, reading.frame, reading.buttons});
    else
      left_out_++;
  }
  time_s_ += tick_s_;
  return status;
}

Status RecordingDevice::save(const std::filesystem::path& path) const {
  NewFile file(path);
  file.write(kHeading);
  for (const RecordedReading& r : readings_) {
    char line[512];
    int n = std::snprintf(line, sizeof line, "%.6f,%.17g,%.17g,%.17g", r.time_s, r.position_mm.x(),
                          r.position_mm.y(), r.position_mm.z());
    for (int i = 0; i < 9; i++)
      n += std::snprintf(line + n, sizeof line - static_cast<size_t>(n), ",%.17g",
                         r.frame(i / 3, i % 3));
    std::snprintf(line + n, sizeof line - static_cast<size_t>(n), ",%u\n", r.buttons);
    file.write(std::string_view(line));
  }
  return file.commit();
}

ReplayDevice::ReplayDevice(std::vector<RecordedReading> readings,
                           const DeviceCapabilities& capabilities)
    : readings_(std::move(readings)), capabilities_(capabilities) {
  KIBORI_CHECK(!readings_.empty());
}

DeviceStatus ReplayDevice::read(DeviceReading& reading) {
  const size_t i = std::min(next_, readings_.size() - 1);
  const RecordedReading &now = readings_[i], &before = readings_[i > 0 ? i - 1 : 0];
  reading.position_mm = now.position_mm;
  reading.frame = now.frame;
  reading.buttons = now.buttons;
  const double since = now.time_s - before.time_s;
  reading.velocity_mm_s = since > 0 && !finished()
                              ? Vec3((now.position_mm - before.position_mm) / since)
                              : Vec3(Vec3::Zero());
  reading.age_s = 0;
  if (!finished()) next_++;
  return DeviceStatus::ok;
}

}  // namespace kibori
