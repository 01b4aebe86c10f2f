// SPDX-License-Identifier: MIT
#include <kibori/devices/open_haptics.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>

#include <kibori/base/handover.h>
#include <kibori/devices/shared_library.h>

namespace kibori {

// libHD, by its documented interface: mm, N, mN m; x right, y up, z to the user.
using HdHandle = unsigned;
struct HdError {
  unsigned code;
  int internal;
  HdHandle device;
};
using HdCallback = unsigned (*)(void*);

namespace {

using Clock = std::chrono::steady_clock;

constexpr unsigned kContinue = 1, kInvalidHandle = 0xffffffffu;
constexpr unsigned kButtonState = 0x2000, kPosition = 0x2050, kVelocity = 0x2051,
                   kTransform = 0x2052, kForce = 0x2700, kTorque = 0x2701, kForceOutput = 0x4000,
                   kNominalMaxForce = 0x2603;
constexpr unsigned kCommunication = 0x0302, kCommunicationSettings = 0x0303;
constexpr unsigned short kHighest = 0xffff;
// A force that is not renewed within this time is dropped.
constexpr auto kForceWatchdog = std::chrono::milliseconds(20);

Vec3 from_hd(const double (&v)[3]) { return {v[0], -v[2], v[1]}; }

}  // namespace

struct OpenHapticsDevice::Link {
  SharedLibrary library;
  HdHandle (*init_device)(const char*) = nullptr;
  void (*disable_device)(HdHandle) = nullptr;
  void (*enable)(unsigned) = nullptr;
  unsigned long (*schedule)(HdCallback, void*, unsigned short) = nullptr;
  void (*unschedule)(unsigned long) = nullptr;
  void (*start_scheduler)() = nullptr;
  void (*stop_scheduler)() = nullptr;
  void (*begin_frame)(HdHandle) = nullptr;
  void (*end_frame)(HdHandle) = nullptr;
  void (*get_doubles)(unsigned, double*) = nullptr;
  void (*get_integers)(unsigned, int*) = nullptr;
  void (*set_doubles)(unsigned, const double*) = nullptr;
  HdError (*get_error)() = nullptr;
  const char* (*error_string)(unsigned) = nullptr;

  HdHandle device = kInvalidHandle;
  unsigned long scheduled = 0;
  bool running = false;
  DeviceCapabilities capabilities;

  struct Timed {
    DeviceReading reading;
    Clock::time_point at;
  };
  struct Command {
    Wrench wrench;
    Clock::time_point at;
  };
  LatestValue<Timed> readings;
  LatestValue<Command> commands;
  Command command;  // the scheduler thread's
  Timed last;       // the servo loop's
  bool seen = false;
  std::atomic<unsigned> error{0};

  // Runs on the scheduler's thread.
  void tick() {
    begin_frame(device);
    double position[3], velocity[3], transform[16];
    int buttons = 0;
    get_doubles(kPosition, position);
    get_doubles(kVelocity, velocity);
    get_doubles(kTransform, transform);
    get_integers(kButtonState, &buttons);
    Timed now;
    now.reading.position_mm = from_hd(position);
    now.reading.velocity_mm_s = from_hd(velocity);
    now.reading.buttons = static_cast<uint32_t>(buttons);
    // The array holds the rotation column by column, in the device's axes. Convert rows and columns
    // to Kibori's axes.
    Mat3 theirs, turn;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) theirs(i, j) = transform[4 * j + i];
    turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    now.reading.frame = turn * theirs * turn.transpose();
    now.at = Clock::now();
    const bool good = now.reading.position_mm.allFinite() &&
                      now.reading.velocity_mm_s.allFinite() && now.reading.frame.allFinite();

    commands.take(command);
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    if (good && error == 0 && now.at - command.at < kForceWatchdog) {
      force = command.wrench.force;
      torque = command.wrench.moment;  // N mm equal mN m
    }
    const double f[3] = {force.x(), force.z(), -force.y()},
                 t[3] = {torque.x(), torque.z(), -torque.y()};
    set_doubles(kForce, f);
    if (capabilities.dof_out == 6) set_doubles(kTorque, t);
    end_frame(device);
    if (const HdError failure = get_error(); failure.code != 0 && error == 0) error = failure.code;
    if (!good && error == 0) error = 1;
    if (good) readings.put(now);
  }
  static unsigned call(void* link) {
    static_cast<Link*>(link)->tick();
    return kContinue;
  }
  DeviceStatus fault() const {
    const unsigned code = error;
    return code == 0                                                  ? DeviceStatus::ok
           : code == kCommunication || code == kCommunicationSettings ? DeviceStatus::unplugged
                                                                      : DeviceStatus::failed;
  }
};

OpenHapticsDevice::OpenHapticsDevice(std::unique_ptr<Link> link) : link_(std::move(link)) {}

Result<std::unique_ptr<OpenHapticsDevice>> OpenHapticsDevice::open() {
  std::vector<std::string> names;
  if (const char* sdk = std::getenv("OH_SDK_BASE"); sdk && *sdk)
    for (const char* folder : {"/lib/", "/lib64/", "/lib/lin-x86_64/"})
      names.push_back(std::string(sdk) + folder + "libHD.so");
  for (const char* file : {"libHD.so", "libHD.so.3.4", "libHD.so.3.0"}) names.emplace_back(file);
  Result<SharedLibrary> library = SharedLibrary::open(names);
  if (!library)
    return Error{
        "OpenHaptics' libHD.so was not found; install OpenHaptics and the driver from 3D Systems, "
        "or set "
        "OH_SDK_BASE to its folder"};
  auto link = std::make_unique<Link>();
  link->library = std::move(library).value();
  const char* missing = nullptr;
  const auto need = [&](const char* name, auto*& function) {
    if (!link->library.find(name, function) && !missing) missing = name;
  };
  need("hdInitDevice", link->init_device);
  need("hdDisableDevice", link->disable_device);
  need("hdEnable", link->enable);
  need("hdScheduleAsynchronous", link->schedule);
  need("hdUnschedule", link->unschedule);
  need("hdStartScheduler", link->start_scheduler);
  need("hdStopScheduler", link->stop_scheduler);
  need("hdBeginFrame", link->begin_frame);
  need("hdEndFrame", link->end_frame);
  need("hdGetDoublev", link->get_doubles);
  need("hdGetIntegerv", link->get_integers);
  need("hdSetDoublev", link->set_doubles);
  need("hdGetError", link->get_error);
  need("hdGetErrorString", link->error_string);
  if (missing)
    return Error{std::string("OpenHaptics' library has no ") + missing + "; install a newer one"};

  std::unique_ptr<OpenHapticsDevice> device(new OpenHapticsDevice(std::move(link)));
  Link& l = *device->link_;
  const auto failure = [&](const char* what, unsigned code) {
    const char* reason = l.error_string(code);
    return Error{std::string("OpenHaptics device: ") + what +
                 (reason ? std::string(": ") + reason : "")};
  };
  l.device = l.init_device(nullptr);
  if (const HdError error = l.get_error(); error.code != 0 || l.device == kInvalidHandle) {
    l.device = kInvalidHandle;
    return failure("could not be opened", error.code);
  }
  l.enable(kForceOutput);
  double max = 0;
  l.get_doubles(kNominalMaxForce, &max);
  DeviceCapabilities& c = l.capabilities;
  c.name = "Touch (OpenHaptics)";
  c.dof_in = 6;
  c.dof_out = 3;
  c.force_n = std::isfinite(max) && max > 0 ? max : 3.3;
  c.damping_ns_mm = 0.0003;
  c.stiffness_n_mm = 0.3;
  l.scheduled = l.schedule(&Link::call, &l, kHighest);
  l.start_scheduler();
  l.running = true;
  if (const HdError error = l.get_error(); error.code != 0)
    return failure("the scheduler did not start", error.code);
  return device;
}

OpenHapticsDevice::~OpenHapticsDevice() {
  if (link_->running) {
    link_->stop_scheduler();
    link_->unschedule(link_->scheduled);
  }
  if (link_->device != kInvalidHandle) link_->disable_device(link_->device);
}

const DeviceCapabilities& OpenHapticsDevice::capabilities() const { return link_->capabilities; }

DeviceStatus OpenHapticsDevice::read(DeviceReading& reading) {
  if (const DeviceStatus fault = link_->fault(); fault != DeviceStatus::ok) return fault;
  link_->seen |= link_->readings.take(link_->last);
  reading = link_->last.reading;
  if (!link_->seen) return reading.age_s = kUnknownAge, DeviceStatus::stale;
  reading.age_s = std::chrono::duration<double>(Clock::now() - link_->last.at).count();
  return reading.age_s < 0.002 ? DeviceStatus::ok : DeviceStatus::stale;
}

DeviceStatus OpenHapticsDevice::write(const Wrench& wrench) {
  if (const DeviceStatus fault = link_->fault(); fault != DeviceStatus::ok) return fault;
  link_->commands.put({wrench, Clock::now()});
  return DeviceStatus::ok;
}

std::string OpenHapticsDevice::complaint() const {
  const unsigned code = link_->error;
  if (code == 0) return {};
  const char* reason = link_->error_string(code);
  return link_->capabilities.name + ": " + (reason ? reason : "an unknown error");
}

}  // namespace kibori
