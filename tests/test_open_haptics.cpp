// SPDX-License-Identifier: MIT
// The OpenHaptics driver against a library with the vendor's interface.
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/devices/open_haptics.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/shared_library.h>

#include "tests/device_support.h"
#include "tests/fake_hd.h"
#include "tests/support.h"

namespace kibori::open_haptics_tests {
namespace {

using std::chrono::milliseconds;
using test::read_fresh;

class OpenHaptics : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("OH_SDK_BASE", KIBORI_FAKE_SDK, 1);
    auto library = SharedLibrary::open({KIBORI_FAKE_SDK "/lib/libHD.so"});
    ASSERT_TRUE(library.ok()) << library.error();
    library_ = std::move(library).value();
    FakeHd* (*get)() = nullptr;
    ASSERT_TRUE(library_.find("fake_hd", get));
    fake_ = get();
    fake_->init_error = fake_->error = 0;
    fake_->max_force = 3.3;
    fake_->disabled = fake_->unscheduled = 0;
  }
  void TearDown() override { unsetenv("OH_SDK_BASE"); }
  SharedLibrary library_;
  FakeHd* fake_ = nullptr;
};

TEST_F(OpenHaptics, ReadsAndWritesInOurAxes) {
  auto opened = open_device("openhaptics");
  ASSERT_TRUE(opened.ok()) << opened.error();
  Device& device = *opened.value();
  EXPECT_TRUE(fake_->output);
  EXPECT_EQ(device.capabilities().force_n, 3.3);
  fake_->x = 10;
  fake_->buttons = 2;
  std::this_thread::sleep_for(milliseconds(20));
  DeviceReading reading;
  ASSERT_EQ(read_fresh(device, reading), DeviceStatus::ok);
  EXPECT_NEAR((reading.position_mm - Vec3(10, 30, 20)).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.velocity_mm_s - Vec3(100, 0, 0)).norm(), 0, 1e-9);
  // A quarter turn about the vendor's y, which is our z.
  EXPECT_NEAR((reading.frame * Vec3::UnitZ() - Vec3::UnitZ()).norm(), 0, 1e-9);
  EXPECT_NEAR((reading.frame * Vec3::UnitX() - Vec3::UnitY()).norm(), 0, 1e-9);
  EXPECT_EQ(reading.buttons, 2u);
  for (int i = 0; i < 20; i++) {
    ASSERT_EQ(device.write({Vec3(1, 2, 3), Vec3::Zero()}), DeviceStatus::ok);
    std::this_thread::sleep_for(milliseconds(1));
  }
  EXPECT_EQ(fake_->force_y, 3);   // up
  EXPECT_EQ(fake_->force_z, -2);  // to the user
  // Without renewal, the force ends within 20 ms. On a busy machine the thread runs later.
  for (int i = 0; i < 1000 && fake_->force_y != 0; i++)
    std::this_thread::sleep_for(milliseconds(2));
  EXPECT_EQ(fake_->force_y, 0);
  opened.value().reset();
  EXPECT_EQ(fake_->disabled, 1);
  EXPECT_EQ(fake_->unscheduled, 1);
}

TEST_F(OpenHaptics, EveryErrorCodeIsAFaultThatStays) {
  for (const unsigned code :
       {0x0100u, 0x0301u, 0x0302u, 0x0303u, 0x0400u, 0x0402u, 0x0403u, 0x0404u, 0x0500u}) {
    fake_->error = 0;
    auto opened = OpenHapticsDevice::open();
    ASSERT_TRUE(opened.ok()) << opened.error();
    DeviceReading reading;
    ASSERT_EQ(read_fresh(*opened.value(), reading), DeviceStatus::ok);
    fake_->error = code;
    const DeviceStatus expected =
        code == 0x0302 || code == 0x0303 ? DeviceStatus::unplugged : DeviceStatus::failed;
    DeviceStatus status = DeviceStatus::ok;
    for (int i = 0; i < 1000 && (status == DeviceStatus::ok || status == DeviceStatus::stale);
         i++) {
      std::this_thread::sleep_for(milliseconds(1));
      status = opened.value()->read(reading);
    }
    EXPECT_EQ(status, expected);
    fake_->error = 0;
    std::this_thread::sleep_for(milliseconds(3));
    EXPECT_EQ(opened.value()->read(reading), expected);
    EXPECT_EQ(opened.value()->write({}), expected);
    EXPECT_NE(opened.value()->complaint().find("what the vendor says"), std::string::npos);
  }
  fake_->init_error = 0x0400;
  EXPECT_NE(OpenHapticsDevice::open().error().find("what the vendor says"), std::string::npos);
  setenv("OH_SDK_BASE", "/nonexistent", 1);
  EXPECT_NE(OpenHapticsDevice::open().error().find("OH_SDK_BASE"), std::string::npos);
}

}  // namespace
}  // namespace kibori::open_haptics_tests
