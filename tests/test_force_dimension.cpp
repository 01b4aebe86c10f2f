// SPDX-License-Identifier: MIT
// The Force Dimension driver against a library with the vendor's interface.
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/devices/force_dimension.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/shared_library.h>

#include "tests/fake_dhd.h"
#include "tests/support.h"

namespace kibori::force_dimension_tests {
namespace {

class ForceDimension : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("FORCEDIM_SDK", KIBORI_FAKE_SDK, 1);
    auto library = SharedLibrary::open({KIBORI_FAKE_SDK "/lib/libdhd.so.3"});
    ASSERT_TRUE(library.ok()) << library.error();
    library_ = std::move(library).value();
    FakeDhd* (*get)() = nullptr;
    ASSERT_TRUE(library_.find("fake_dhd", get));
    fake_ = get();
    *fake_ = FakeDhd();
  }
  void TearDown() override { unsetenv("FORCEDIM_SDK"); }
  SharedLibrary library_;
  FakeDhd* fake_ = nullptr;
};

TEST_F(ForceDimension, ReadsAndWritesInOurAxes) {
  auto opened = ForceDimensionDevice::open();
  ASSERT_TRUE(opened.ok()) << opened.error();
  ForceDimensionDevice& device = *opened.value();
  EXPECT_EQ(device.capabilities().dof_out, 6);
  EXPECT_EQ(device.capabilities().force_n, 12);
  EXPECT_EQ(fake_->forces_on, 1);
  EXPECT_EQ(fake_->watchdog, 160);  // 20 ms in steps of 125 us
  // The vendor's frame: x to the user, y right, z up.
  fake_->position[0] = -0.01, fake_->position[1] = 0.02, fake_->position[2] = 0.03;
  fake_->velocity[1] = 0.5;
  fake_->buttons = 9;
  // A quarter turn about z has the same matrix in both frames, because both have the same z.
  const double turn[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  std::memcpy(fake_->frame, turn, sizeof turn);
  DeviceReading reading;
  ASSERT_EQ(device.read(reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(20, 10, 30)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.velocity_mm_s - Vec3(500, 0, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);
  EXPECT_EQ(reading.buttons, 9u);
  // From our frame to the vendor's and back.
  ASSERT_EQ(device.write({Vec3(1, 2, 3), Vec3(4, 5, 6)}), DeviceStatus::ok);
  EXPECT_EQ(fake_->force[0], -2);
  EXPECT_EQ(fake_->force[1], 1);
  EXPECT_EQ(fake_->force[2], 3);
  EXPECT_NEAR(fake_->torque[0], -0.005, 1e-12);
  EXPECT_NEAR(fake_->torque[1], 0.004, 1e-12);
  // The library reports that a read came too soon and returned the last value.
  fake_->read_result = 1;
  EXPECT_EQ(device.read(reading), DeviceStatus::stale);
  fake_->read_result = 0;
  EXPECT_EQ(device.read(reading), DeviceStatus::ok);
  EXPECT_EQ(reading.age_s, 0);
  // A saturated motor is not an error.
  fake_->write_result = 2;
  EXPECT_EQ(device.write({}), DeviceStatus::ok);
  opened.value().reset();
  EXPECT_EQ(fake_->closed, 1);
  EXPECT_EQ(fake_->force[2], 0);
}

TEST_F(ForceDimension, EveryErrorCodeIsAFaultThatStays) {
  for (int code = 0; code <= 21; code++)
    for (int FakeDhd::*where : {&FakeDhd::read_result, &FakeDhd::velocity_result,
                                &FakeDhd::frame_result, &FakeDhd::write_result}) {
      *fake_ = FakeDhd();
      auto opened = ForceDimensionDevice::open();
      ASSERT_TRUE(opened.ok()) << opened.error();
      DeviceReading reading;
      EXPECT_EQ(opened.value()->read(reading), DeviceStatus::ok);
      EXPECT_EQ(opened.value()->write({Vec3(0, 0, 5), Vec3::Zero()}), DeviceStatus::ok);
      fake_->*where = -1;
      fake_->error = code;
      const bool gone = code == 2 || code == 5 || code == 6 || code == 12;
      const DeviceStatus expected = gone ? DeviceStatus::unplugged : DeviceStatus::failed;
      EXPECT_EQ(where == &FakeDhd::write_result ? opened.value()->write({})
                                                : opened.value()->read(reading),
                expected);
      fake_->*where = 0;
      EXPECT_EQ(opened.value()->read(reading), expected);
      EXPECT_EQ(opened.value()->write({}), expected);
      EXPECT_NE(opened.value()->complaint().find("what the vendor says"), std::string::npos);
      // The previous force is cleared, if the device can still be reached.
      if (!gone && where != &FakeDhd::write_result) {
        EXPECT_EQ(fake_->force[2], 0);
      }
    }
  // A position that is not finite is an error.
  *fake_ = FakeDhd();
  auto opened = ForceDimensionDevice::open();
  ASSERT_TRUE(opened.ok());
  fake_->position[0] = std::numeric_limits<double>::quiet_NaN();
  DeviceReading reading;
  EXPECT_EQ(opened.value()->read(reading), DeviceStatus::failed);
}

TEST_F(ForceDimension, ReportsWhyItIsMissing) {
  fake_->devices = 0;
  EXPECT_NE(ForceDimensionDevice::open().error().find("plugged in"), std::string::npos);
  fake_->devices = -1;
  EXPECT_FALSE(ForceDimensionDevice::open().ok());
  *fake_ = FakeDhd();
  fake_->open_result = -1;
  EXPECT_NE(ForceDimensionDevice::open().error().find("what the vendor says"), std::string::npos);
  *fake_ = FakeDhd();
  fake_->enable_result = -1;
  EXPECT_NE(ForceDimensionDevice::open().error().find("switched on"), std::string::npos);
  EXPECT_EQ(fake_->closed, 1);
  // The path in FORCEDIM_SDK does not exist.
  setenv("FORCEDIM_SDK", "/nonexistent", 1);
  EXPECT_NE(ForceDimensionDevice::open().error().find("FORCEDIM_SDK"), std::string::npos);
  *fake_ = FakeDhd();
  fake_->wrist = fake_->active_wrist = false;
  fake_->max_force = std::nan("");
  setenv("FORCEDIM_SDK", KIBORI_FAKE_SDK, 1);
  auto opened = open_device("forcedim");
  ASSERT_TRUE(opened.ok()) << opened.error();
  EXPECT_EQ(opened.value()->capabilities().dof_in, 3);
  EXPECT_EQ(opened.value()->capabilities().dof_out, 3);
  EXPECT_GT(opened.value()->capabilities().force_n, 0);
}

}  // namespace
}  // namespace kibori::force_dimension_tests
