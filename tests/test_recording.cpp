// SPDX-License-Identifier: MIT
// Devices that replay recorded readings, and the list of devices.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/devices/recording.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>

#include "tests/support.h"

namespace kibori::recording_tests {
namespace {

TEST(Recording, PlaysBackWhatWasRead) {
  VirtualDeviceSettings settings;
  const auto script = [](double t) {
    return VirtualDevice::Target{Vec3(std::sin(t), t, 0), rotation(Vec3(0, 0, t)),
                                 t > 0.01 ? 1u : 0u};
  };
  RecordingDevice recorder(std::make_unique<VirtualDevice>(settings, script), 0.001, 40);
  std::vector<DeviceReading> seen;
  DeviceReading reading;
  for (int i = 0; i < 60; i++) {
    ASSERT_EQ(recorder.read(reading), DeviceStatus::ok);
    seen.push_back(reading);
  }
  ASSERT_EQ(recorder.readings().size(), 40u);
  const auto path = std::filesystem::temp_directory_path() /
                    ("kibori-recording-" + std::to_string(getpid()) + ".csv");
  ASSERT_TRUE(recorder.save(path).ok());
  auto opened = open_device("replay:" + path.string());
  ASSERT_TRUE(opened.ok()) << opened.error();
  for (int i = 0; i < 60; i++) {
    ASSERT_EQ(opened.value()->read(reading), DeviceStatus::ok);
    const DeviceReading& was = seen[static_cast<size_t>(std::min(i, 39))];
    EXPECT_EQ(reading.position_mm, was.position_mm);
    EXPECT_EQ(reading.frame, was.frame);
    EXPECT_EQ(reading.buttons, was.buttons);
  }
  std::filesystem::remove(path);
  EXPECT_FALSE(open_device("replay:" + path.string()).ok());
}

TEST(Recording, RefusesWhatIsNone) {
  const auto path =
      std::filesystem::temp_directory_path() / ("kibori-bad-" + std::to_string(getpid()) + ".csv");
  const std::string kHead = "t_s,x_mm,y_mm,z_mm,r11,r12,r13,r21,r22,r23,r31,r32,r33,buttons\n";
  const std::string good = "0.001,1,2,3,1,0,0,0,1,0,0,0,1,0";
  for (const std::string& bad : std::vector<std::string>{
           std::string(), std::string("heading\n"), kHead + good + ",7\n",
           kHead + good.substr(0, 20) + "\n", "h\nnan" + good.substr(5) + "\n",
           "h\n0.001,1,2,3,1,0,0,0,1,0,0,0,-1,0\n", kHead + good + "1e99\n",
           kHead + good.substr(0, good.size() - 1) + "-1\n", std::string("h\n\0\0\0", 5),
           kHead + good + "\n" + std::string(1, 0) + good, kHead + good + "\n\n"}) {
    {
      std::FILE* file = std::fopen(path.c_str(), "wb");
      ASSERT_NE(file, nullptr);
      std::fwrite(bad.data(), 1, bad.size(), file);
      std::fclose(file);
    }
    const auto read = read_recording(path);
    ASSERT_FALSE(read.ok()) << bad;
    EXPECT_NE(read.error().find(path.string()), std::string::npos);
  }
  std::filesystem::remove(path);
}

TEST(Registry, KnowsTheKinds) {
  for (const char* bad : {"", "phantom", "haply:", "haply:host:", "haply::1", "vrpn:", "vrpn:a"})
    EXPECT_FALSE(open_device(bad).ok()) << bad;
  EXPECT_NE(open_device("phantom").error().find("vrpn:NAME@HOST"), std::string::npos);
  bool simulated = false;
  for (const DeviceFound& found : find_devices()) {
    EXPECT_FALSE(found.text.empty());
    simulated |= found.name == "virtual" && found.present;
  }
  EXPECT_TRUE(simulated);
}

}  // namespace
}  // namespace kibori::recording_tests
