// SPDX-License-Identifier: MIT
#include <kibori/devices/force_dimension.h>

#include <chrono>
#include <cmath>
#include <cstdlib>

namespace kibori {
namespace {

// Functions of DHD return -1 for an error; dhdErrorGetLast returns its kind. Otherwise they return
// 0, 1 (too soon after the last call: same values as then) or 2 (a motor is at its limit). Units:
// metres, N, N m, radians. x points to the user, y right, z up.
constexpr int kTooSoon = 1;
constexpr int kErrorCommunication = 2, kErrorNoDevice = 5, kErrorNotAvailable = 6,
              kErrorNotReady = 12;
// If Kibori sends nothing for 20 ms, the device stops its force. The unit is 125 us.
constexpr unsigned char kWatchdogSteps = 160;

// Converts to Kibori's axes: x right, y away from the user, z up.
Vec3 from_dhd(double x, double y, double z) { return {y, -x, z}; }

}  // namespace

struct ForceDimensionDevice::Functions {
  int (*get_device_count)();
  int (*open_id)(char);
  int (*close)(char);
  const char* (*get_system_name)(char);
  int (*get_position)(double*, double*, double*, char);
  int (*get_orientation_frame)(double[3][3], char);
  int (*get_linear_velocity)(double*, double*, double*, char);
  unsigned int (*get_button_mask)(char);
  int (*set_force_and_torque)(double, double, double, double, double, double, double, char);
  int (*enable_force)(unsigned char, char);
  int (*set_watchdog)(unsigned char, char);
  double (*get_max_force)(char);
  bool (*has_wrist)(char);
  bool (*has_active_wrist)(char);
  const char* (*error_get_last_str)();
  int (*error_get_last)();
};

ForceDimensionDevice::ForceDimensionDevice() : dhd_(std::make_unique<Functions>()) {}

Result<std::unique_ptr<ForceDimensionDevice>> ForceDimensionDevice::open() {
  std::vector<std::string> names;
  if (const char* sdk = std::getenv("FORCEDIM_SDK"); sdk && *sdk)
    for (const char* folder : {"/lib/release/lin-x86_64-gcc/", "/lib/", "/"})
      for (const char* file : {"libdrd.so.3", "libdhd.so.3", "libdrd.so", "libdhd.so"})
        names.push_back(std::string(sdk) + folder + file);
  for (const char* file : {"libdrd.so.3", "libdhd.so.3", "libdrd.so", "libdhd.so"})
    names.emplace_back(file);
  Result<SharedLibrary> library = SharedLibrary::open(names);
  if (!library)
    return Error{
        "Force Dimension's library was not found; install its SDK and set FORCEDIM_SDK to its "
        "folder"};
  std::unique_ptr<ForceDimensionDevice> device(new ForceDimensionDevice);
  device->library_ = std::move(library).value();
  Functions& dhd = *device->dhd_;
  const SharedLibrary& in = device->library_;
  const char* missing = nullptr;
  const auto need = [&](const char* name, auto*& function) {
    if (!in.find(name, function) && !missing) missing = name;
  };
  need("dhdGetDeviceCount", dhd.get_device_count);
  need("dhdOpenID", dhd.open_id);
  need("dhdClose", dhd.close);
  need("dhdGetSystemName", dhd.get_system_name);
  need("dhdGetPosition", dhd.get_position);
  need("dhdGetOrientationFrame", dhd.get_orientation_frame);
  need("dhdGetLinearVelocity", dhd.get_linear_velocity);
  need("dhdGetButtonMask", dhd.get_button_mask);
  need("dhdSetForceAndTorqueAndGripperForce", dhd.set_force_and_torque);
  need("dhdEnableForce", dhd.enable_force);
  need("dhdSetWatchdog", dhd.set_watchdog);
  need("dhdGetMaxForce", dhd.get_max_force);
  need("dhdHasWrist", dhd.has_wrist);
  need("dhdHasActiveWrist", dhd.has_active_wrist);
  need("dhdErrorGetLastStr", dhd.error_get_last_str);
  need("dhdErrorGetLast", dhd.error_get_last);
  if (missing)
    return Error{std::string("Force Dimension's library has no ") + missing +
                 "; install a newer SDK"};

  const auto failure = [&](const char* what) {
    const char* reason = dhd.error_get_last_str();
    return Error{std::string("Force Dimension device: ") + what +
                 (reason ? std::string(": ") + reason : "")};
  };
  if (dhd.get_device_count() <= 0)
    return Error{"no Force Dimension device or Falcon is plugged in (or no permission to use it)"};
  const int id = dhd.open_id(0);
  if (id < 0) return failure("could not be opened");
  device->id_ = static_cast<signed char>(id);
  const auto ID = static_cast<char>(id);
  if (dhd.enable_force(1, ID) < 0) return failure("forces could not be switched on");
  dhd.set_watchdog(kWatchdogSteps, ID);
  DeviceCapabilities& c = device->capabilities_;
  const char* name = dhd.get_system_name(ID);
  c.name = name ? name : "Force Dimension device";
  c.dof_in = dhd.has_wrist(ID) ? 6 : 3;
  c.dof_out = dhd.has_active_wrist(ID) ? 6 : 3;
  const double max = dhd.get_max_force(ID);
  const bool falcon =
      c.name.find("FALCON") != std::string::npos || c.name.find("Falcon") != std::string::npos;
  c.force_n = std::isfinite(max) && max > 0 ? max : falcon ? 8 : 12;
  c.torque_nmm = c.dof_out == 6 ? 100 : 0;
  c.force_rate_n_s = 4000;
  c.damping_ns_mm = falcon ? 0.003 : 0.005;
  c.stiffness_n_mm = falcon ? 1.5 : 2.5;
  return device;
}

ForceDimensionDevice::~ForceDimensionDevice() {
  if (id_ < 0) return;
  const auto ID = static_cast<char>(id_);
  if (!unplugged_) dhd_->set_force_and_torque(0, 0, 0, 0, 0, 0, 0, ID);
  dhd_->close(ID);
}

DeviceStatus ForceDimensionDevice::judge(int result) {
  if (result >= 0) return result == kTooSoon ? DeviceStatus::stale : DeviceStatus::ok;
  const int kind = dhd_->error_get_last();
  unplugged_ |= kind == kErrorCommunication || kind == kErrorNoDevice ||
                kind == kErrorNotAvailable || kind == kErrorNotReady;
  failed_ = true;
  return unplugged_ ? DeviceStatus::unplugged : DeviceStatus::failed;
}

DeviceStatus ForceDimensionDevice::read(DeviceReading& reading) {
  if (failed_) return unplugged_ ? DeviceStatus::unplugged : DeviceStatus::failed;
  const auto ID = static_cast<char>(id_);
  double x = 0, y = 0, z = 0;
  const DeviceStatus status = judge(dhd_->get_position(&x, &y, &z, ID));
  if (status == DeviceStatus::failed || status == DeviceStatus::unplugged) return status;
  reading.position_mm = 1000 * from_dhd(x, y, z);
  if (const DeviceStatus s = judge(dhd_->get_linear_velocity(&x, &y, &z, ID)); failed_) return s;
  reading.velocity_mm_s = 1000 * from_dhd(x, y, z);
  if (capabilities_.dof_in == 6) {
    double r[3][3];
    if (const DeviceStatus s = judge(dhd_->get_orientation_frame(r, ID)); failed_) return s;
    // Rows and columns of the rotation use DHD's axes. Convert both to Kibori's axes.
    Mat3 theirs, turn;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) theirs(i, j) = r[i][j];
    turn << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    reading.frame = turn * theirs * turn.transpose();
  }
  reading.buttons = dhd_->get_button_mask(ID);
  if (!reading.position_mm.allFinite() || !reading.velocity_mm_s.allFinite() ||
      !reading.frame.allFinite()) {
    failed_ = true;
    return DeviceStatus::failed;
  }
  const Clock::time_point now = Clock::now();
  if (status == DeviceStatus::ok) fresh_ = now;
  reading.age_s = std::chrono::duration<double>(now - fresh_).count();
  return status;
}

DeviceStatus ForceDimensionDevice::write(const Wrench& wrench) {
  if (failed_) {
    // Stop the force that the device still produces.
    if (!unplugged_) dhd_->set_force_and_torque(0, 0, 0, 0, 0, 0, 0, static_cast<char>(id_));
    return unplugged_ ? DeviceStatus::unplugged : DeviceStatus::failed;
  }
  // Convert back to the device's axes: x = -y', y = x'. N mm to N m.
  const Vec3 &f = wrench.force, m = wrench.moment / 1000;
  const DeviceStatus status = judge(dhd_->set_force_and_torque(-f.y(), f.x(), f.z(), -m.y(), m.x(),
                                                               m.z(), 0, static_cast<char>(id_)));
  return status == DeviceStatus::stale ? DeviceStatus::ok : status;
}

std::string ForceDimensionDevice::complaint() const {
  if (!failed_) return {};
  const char* reason = dhd_->error_get_last_str();
  return capabilities_.name + ": " + (reason ? reason : "an unknown error");
}

}  // namespace kibori
