// SPDX-License-Identifier: MIT
// The game controller against SDL's own virtual one.
#include <atomic>
#include <chrono>
#include <thread>

#include <SDL2/SDL.h>
#include <gtest/gtest.h>

#include <kibori/devices/gamepad_device.h>

namespace kibori::gamepad_tests {
namespace {

using std::chrono::milliseconds;

class Gamepad : public ::testing::Test {
 protected:
  void SetUp() override {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    ASSERT_EQ(SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER), 0) << SDL_GetError();
    for (int i = 0; i < SDL_NumJoysticks(); i++)
      if (SDL_IsGameController(i)) GTEST_SKIP() << "a real game controller is plugged in";
    SDL_VirtualJoystickDesc desc{};
    desc.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    desc.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    desc.naxes = SDL_CONTROLLER_AXIS_MAX;
    desc.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
    desc.name = "a virtual pad";
    desc.userdata = this;
    desc.Rumble = [](void* self, Uint16 low, Uint16 high) {
      static_cast<Gamepad*>(self)->low_ = low;
      static_cast<Gamepad*>(self)->high_ = high;
      return 0;
    };
    index_ = SDL_JoystickAttachVirtualEx(&desc);
    ASSERT_GE(index_, 0) << SDL_GetError();
    pad_ = SDL_JoystickOpen(index_);
    ASSERT_NE(pad_, nullptr) << SDL_GetError();
    push(SDL_CONTROLLER_AXIS_TRIGGERLEFT, -32768);
    push(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, -32768);
  }
  void TearDown() override {
    if (pad_) SDL_JoystickClose(pad_);
    if (index_ >= 0) SDL_JoystickDetachVirtual(index_);
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }
  void push(int axis, Sint16 value) { ASSERT_EQ(SDL_JoystickSetVirtualAxis(pad_, axis, value), 0); }
  // Reads, and answers with a force, for this time.
  static DeviceReading hold(Device& device, double seconds, const Vec3& force = Vec3::Zero()) {
    DeviceReading reading;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
      device.read(reading);
      device.write({force, Vec3::Zero()});
      std::this_thread::sleep_for(milliseconds(1));
    }
    return reading;
  }
  template <class F>
  static bool soon(F&& what) {
    for (int i = 0; i < 2000 && !what(); i++) std::this_thread::sleep_for(milliseconds(1));
    return what();
  }

  int index_ = -1;
  SDL_Joystick* pad_ = nullptr;
  std::atomic<int> low_{-1}, high_{-1};
};

TEST_F(Gamepad, SticksMoveTheHandAndButtonsAreReported) {
  auto opened = GamepadDevice::open();
  ASSERT_TRUE(opened.ok()) << opened.error();
  Device& device = *opened.value();
  EXPECT_EQ(device.capabilities().name, "a virtual pad");
  const Vec3 start = hold(device, 0.1).position_mm;
  EXPECT_LT((start - Vec3(0, 0, 60)).norm(), 0.01);  // above the work
  push(SDL_CONTROLLER_AXIS_LEFTX, 32767);
  push(SDL_CONTROLLER_AXIS_LEFTY, -32768);  // up: away
  push(SDL_CONTROLLER_AXIS_RIGHTY, 32767);  // down
  ASSERT_EQ(SDL_JoystickSetVirtualButton(pad_, SDL_CONTROLLER_BUTTON_B, 1), 0);
  DeviceReading moved = hold(device, 0.2);
  EXPECT_GT(moved.position_mm.x(), 2);
  EXPECT_GT(moved.position_mm.y(), 2);
  EXPECT_LT(moved.position_mm.z(), 58);
  EXPECT_LT(moved.velocity_mm_s.norm(), 200);
  EXPECT_EQ(moved.buttons, 2u);
  // To the edge of the workspace and no farther.
  moved = hold(device, 1.2);
  EXPECT_LE(moved.position_mm.cwiseAbs().maxCoeff(), 60.5);
  EXPECT_GT(moved.position_mm.x(), 50);
  // A worn stick does not rest exactly at its centre.
  push(SDL_CONTROLLER_AXIS_LEFTX, 4000);
  push(SDL_CONTROLLER_AXIS_LEFTY, -4000);
  push(SDL_CONTROLLER_AXIS_RIGHTY, 0);
  const Vec3 resting = hold(device, 0.3).position_mm;
  EXPECT_LT((hold(device, 0.2).position_mm - resting).norm(), 0.01);
}

TEST_F(Gamepad, RumblesWithTheForceAndHoldsTheHandBack) {
  auto opened = GamepadDevice::open();
  ASSERT_TRUE(opened.ok()) << opened.error();
  Device& device = *opened.value();
  const double max = device.capabilities().force_n;
  EXPECT_LE(low_, 0);
  // A steady force of half strength: after a while only the slow motor runs.
  hold(device, 0.4, Vec3(0, 0, max / 2));
  for (int i = 0; i < 30 && high_ >= 2000; i++) hold(device, 0.1, Vec3(0, 0, max / 2));
  EXPECT_NEAR(low_, 32768, 1100);
  EXPECT_LT(high_, 2000);
  // A force that alternates: the quick motor also runs.
  bool rough = false;
  for (int i = 0; i < 20; i++) {
    hold(device, 0.02, Vec3(i % 2 ? max : -max, 0, 0));
    rough |= high_ > 30000;
  }
  EXPECT_TRUE(rough);
  // If the force is not renewed, the motors stop.
  EXPECT_TRUE(soon([&] { return low_ == 0 && high_ == 0; }));
  // A wall with the hand's maximum force: the hand does not move.
  hold(device, 0.2);
  push(SDL_CONTROLLER_AXIS_LEFTX, 32767);
  const double x = hold(device, 0.4).position_mm.x();
  for (int i = 0; i < 30; i++) hold(device, 0.01, Vec3(-max, 0, 0));
  EXPECT_LT(hold(device, 0.01, Vec3(-max, 0, 0)).position_mm.x(), x + 1);
  EXPECT_GT(low_, 60000);
}

TEST_F(Gamepad, UnpluggingIsReported) {
  auto opened = GamepadDevice::open();
  ASSERT_TRUE(opened.ok()) << opened.error();
  Device& device = *opened.value();
  hold(device, 0.05);
  EXPECT_EQ(device.complaint(), "");
  SDL_JoystickClose(pad_);
  pad_ = nullptr;
  ASSERT_EQ(SDL_JoystickDetachVirtual(index_), 0);
  index_ = -1;
  DeviceReading reading;
  EXPECT_TRUE(soon([&] { return device.read(reading) == DeviceStatus::unplugged; }));
  EXPECT_EQ(device.write({}), DeviceStatus::unplugged);
  EXPECT_EQ(device.complaint(), "a virtual pad was unplugged");
}

TEST_F(Gamepad, ReportsAMissingDevice) {
  SDL_JoystickClose(pad_);
  pad_ = nullptr;
  ASSERT_EQ(SDL_JoystickDetachVirtual(index_), 0);
  index_ = -1;
  const auto opened = GamepadDevice::open();
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error(), "no game controller is plugged in");
}

}  // namespace
}  // namespace kibori::gamepad_tests
