// SPDX-License-Identifier: MIT
#include <kibori/devices/gamepad_device.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include <kibori/base/handover.h>
#include <kibori/devices/shared_library.h>
#include <kibori/haptics/hand.h>

namespace kibori {
namespace {

using Clock = std::chrono::steady_clock;

// The constants and functions of SDL 2 that this file uses.
constexpr uint32_t kGameControllers = 0x2000;
constexpr int kIgnore = 0, kLeftX = 0, kLeftY = 1, kRightY = 3, kLeftTrigger = 4, kButtons = 4;
struct Sdl {
  int (*init)(uint32_t) = nullptr;
  void (*quit)(uint32_t) = nullptr;
  int (*set_hint)(const char*, const char*) = nullptr;
  int (*event_state)(int) = nullptr;
  int (*count)() = nullptr;
  int (*is_controller)(int) = nullptr;
  void* (*open)(int) = nullptr;
  void (*close)(void*) = nullptr;
  const char* (*name)(void*) = nullptr;
  int (*attached)(void*) = nullptr;
  void (*update)() = nullptr;
  int16_t (*axis)(void*, int) = nullptr;
  uint8_t (*button)(void*, int) = nullptr;
  int (*rumble)(void*, uint16_t, uint16_t, uint32_t) = nullptr;
  const char* (*error)() = nullptr;

  bool find_in(const SharedLibrary& library) {
    return library.find("SDL_InitSubSystem", init) && library.find("SDL_QuitSubSystem", quit) &&
           library.find("SDL_SetHint", set_hint) &&
           library.find("SDL_JoystickEventState", event_state) &&
           library.find("SDL_NumJoysticks", count) &&
           library.find("SDL_IsGameController", is_controller) &&
           library.find("SDL_GameControllerOpen", open) &&
           library.find("SDL_GameControllerClose", close) &&
           library.find("SDL_GameControllerName", name) &&
           library.find("SDL_GameControllerGetAttached", attached) &&
           library.find("SDL_GameControllerUpdate", update) &&
           library.find("SDL_GameControllerGetAxis", axis) &&
           library.find("SDL_GameControllerGetButton", button) &&
           library.find("SDL_GameControllerRumble", rumble) && library.find("SDL_GetError", error);
  }
};

constexpr auto kPoll = std::chrono::milliseconds(4);
constexpr double kPatience_s = 0.1;  // a controller that was not polled for this time is stale
// A rumble stops after this time if nothing renews it.
constexpr uint32_t kRumble_ms = 100;
// A force that is not renewed within this time is dropped.
constexpr auto kRumbleWatchdog = std::chrono::milliseconds(20);
constexpr double kSpeed_mm_s = 80, kFineShare = 0.2;
constexpr double kDeadShare = 0.15;  // dead zone, as a share of a stick's travel, for worn sticks
// Maximum distance of the target from the hand. The maximum force is this distance times the
// stiffness of the hand's spring.
constexpr double kLead_mm = 10;
constexpr double kReach_mm = 60;          // the workspace, in each direction from its centre
constexpr double kRoughness_s = 0.05;     // roughness: the force minus its mean over this time
constexpr double kRoughShare = 1.0 / 3;   // at this share of force_n, it drives its motor fully
constexpr double kLongestStep_s = 0.005;  // longest time step of the simulated hand

// Response of a stick's axis: zero in the middle, fine near it, full at the rim.
double stick(double share) {
  const double beyond = std::clamp((std::abs(share) - kDeadShare) / (1 - kDeadShare), 0.0, 1.0);
  return std::copysign(beyond * beyond, share);
}

HandSettings simulated_hand() {
  HandSettings hand;  // critically damped
  hand.hand_mass_kg = 0.03;
  hand.device_mass_kg = 0.02;
  hand.grip_n_mm = 0.5;
  hand.grip_damping_ns_mm = 0.008;
  hand.device_damping_ns_mm = 0.002;
  return hand;
}

}  // namespace

struct GamepadDevice::Link {
  SharedLibrary library;
  Sdl sdl;
  bool started = false;
  void* pad = nullptr;
  DeviceCapabilities capabilities;

  struct Sticks {
    Vec3 velocity_mm_s = Vec3::Zero();
    uint32_t buttons = 0;
    Clock::time_point at;
  };
  struct Command {
    Vec3 force = Vec3::Zero();
    Clock::time_point at;
  };
  LatestValue<Sticks> readings;
  LatestValue<Command> commands;
  std::atomic<bool> stopping{false}, lost{false};
  std::thread thread;
  // For the servo loop.
  Sticks sticks;
  Vec3 force = Vec3::Zero(), target = Vec3(0, 0, kReach_mm);
  SimulatedHand hand{simulated_hand(), target};
  Clock::time_point last_read;
  bool seen = false;

  ~Link() {
    stopping = true;
    if (thread.joinable()) thread.join();
    if (pad) sdl.close(pad);
    if (started) sdl.quit(kGameControllers);
  }

  Sticks poll() const {
    const auto axis = [&](int i) { return static_cast<double>(sdl.axis(pad, i)) / 32767; };
    Sticks now;
    const double speed = kSpeed_mm_s * (axis(kLeftTrigger) > 0.6 ? kFineShare : 1);
    now.velocity_mm_s =
        speed * Vec3(stick(axis(kLeftX)), -stick(axis(kLeftY)), -stick(axis(kRightY)));
    for (int i = 0; i < kButtons; i++)
      now.buttons |= static_cast<uint32_t>(sdl.button(pad, i) != 0) << i;
    now.at = Clock::now();
    return now;
  }
  // Polls and rumbles until `stopping` is set.
  void run() {
    const double keep = std::exp(-std::chrono::duration<double>(kPoll).count() / kRoughness_s);
    Command command;
    Vec3 slow = Vec3::Zero();
    uint16_t last_low = 0, last_high = 0;
    Clock::time_point rumbled;
    while (!stopping.load(std::memory_order_relaxed)) {
      sdl.update();
      if (!sdl.attached(pad)) {
        lost = true;
        return;
      }
      readings.put(poll());
      commands.take(command);
      const Clock::time_point now = Clock::now();
      const Vec3 device_force =
          now - command.at < kRumbleWatchdog ? command.force : Vec3(Vec3::Zero());
      slow = keep * slow + (1 - keep) * device_force;
      const auto strength = [&](double newton, double full) {
        return static_cast<uint16_t>(std::lround(65535 * std::clamp(newton / full, 0.0, 1.0)));
      };
      const uint16_t low = strength(device_force.norm(), capabilities.force_n),
                     high =
                         strength((device_force - slow).norm(), kRoughShare * capabilities.force_n);
      // Some controllers need time for each command, so the same command is not repeated.
      const bool differs = std::abs(low - last_low) > 1000 || std::abs(high - last_high) > 1000 ||
                           (low == 0 && last_low != 0) || (high == 0 && last_high != 0);
      if (differs || ((low || high) && now - rumbled > std::chrono::milliseconds(kRumble_ms / 2))) {
        sdl.rumble(pad, low, high, kRumble_ms);
        last_low = low;
        last_high = high;
        rumbled = now;
      }
      std::this_thread::sleep_for(kPoll);
    }
    sdl.rumble(pad, 0, 0, 0);
  }
};

GamepadDevice::GamepadDevice(std::unique_ptr<Link> link) : link_(std::move(link)) {}
GamepadDevice::~GamepadDevice() = default;

Result<std::unique_ptr<GamepadDevice>> GamepadDevice::open() {
  auto link = std::make_unique<Link>();
  Result<SharedLibrary> library = SharedLibrary::open({"libSDL2-2.0.so.0"});
  if (!library) return Error{"SDL2 " + library.error() + "; Debian has it as libsdl2-2.0-0"};
  link->library = std::move(library).value();
  Sdl& sdl = link->sdl;
  if (!sdl.find_in(link->library)) return Error{"this SDL2 is too old: 2.0.9 or newer is needed"};
  // Kibori has no window, so SDL must also read the controller without the focus. SDL must not
  // handle Ctrl-C.
  sdl.set_hint("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1");
  sdl.set_hint("SDL_NO_SIGNAL_HANDLERS", "1");
  if (sdl.init(kGameControllers) != 0) return Error{std::string("SDL2: ") + sdl.error()};
  link->started = true;
  sdl.event_state(kIgnore);  // the state is polled, events are not queued
  sdl.update();
  for (int i = 0; i < sdl.count() && !link->pad; i++)
    if (sdl.is_controller(i)) link->pad = sdl.open(i);
  if (!link->pad) return Error{"no game controller is plugged in"};

  DeviceCapabilities& c = link->capabilities;
  const HandSettings hand = simulated_hand();
  const char* const name = sdl.name(link->pad);
  c.name = name ? name : "game controller";
  c.dof_in = c.dof_out = 3;
  c.force_n = hand.grip_n_mm * kLead_mm;
  c.damping_ns_mm = hand.device_damping_ns_mm;
  c.stiffness_n_mm = 1;
  c.workspace_mm = {Vec3::Constant(-kReach_mm), Vec3::Constant(kReach_mm)};
  link->thread = std::thread([running = link.get()] { running->run(); });
  return std::unique_ptr<GamepadDevice>(new GamepadDevice(std::move(link)));
}

const DeviceCapabilities& GamepadDevice::capabilities() const { return link_->capabilities; }

DeviceStatus GamepadDevice::read(DeviceReading& reading) {
  Link& link = *link_;
  if (link.lost.load(std::memory_order_relaxed)) return DeviceStatus::unplugged;
  link.seen |= link.readings.take(link.sticks);
  const Clock::time_point now = Clock::now();
  const double age =
      link.seen ? std::chrono::duration<double>(now - link.sticks.at).count() : kUnknownAge;
  const double passed = std::chrono::duration<double>(now - link.last_read).count();
  link.last_read = now;
  reading.position_mm = link.hand.position_mm();
  reading.velocity_mm_s = link.hand.velocity_mm_s();
  reading.frame = Mat3::Identity();
  reading.buttons = link.sticks.buttons;
  reading.age_s = age;
  if (age > kPatience_s) return DeviceStatus::stale;
  const double dt = std::min(passed, kLongestStep_s);
  const Vec3 before = link.target, at = link.hand.position_mm();
  Vec3 wanted = before + dt * link.sticks.velocity_mm_s;
  if (const double lead = (wanted - at).norm(); lead > kLead_mm)
    wanted = at + kLead_mm / lead * (wanted - at);
  link.target = wanted.cwiseMax(-kReach_mm).cwiseMin(kReach_mm);
  if (dt > 0) link.hand.step(link.force, link.target, (link.target - before) / dt, dt);
  reading.position_mm = link.hand.position_mm();
  reading.velocity_mm_s = link.hand.velocity_mm_s();
  reading.age_s = 0;  // the simulated hand moves between polls, too
  return DeviceStatus::ok;
}

DeviceStatus GamepadDevice::write(const Wrench& wrench) {
  if (link_->lost.load(std::memory_order_relaxed)) return DeviceStatus::unplugged;
  link_->force = wrench.force;
  link_->commands.put({wrench.force, Clock::now()});
  return DeviceStatus::ok;
}

std::string GamepadDevice::complaint() const {
  if (link_->lost) return link_->capabilities.name + " was unplugged";
  const bool silent =
      link_->seen && Clock::now() - link_->sticks.at > std::chrono::duration<double>(kPatience_s);
  return silent ? link_->capabilities.name + " has not answered for 0.1 s" : std::string();
}

}  // namespace kibori
