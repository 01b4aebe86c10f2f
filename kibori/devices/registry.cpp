// SPDX-License-Identifier: MIT
#include <kibori/devices/registry.h>

#include <kibori/devices/dds_device.h>
#include <kibori/devices/dds_link.h>
#include <kibori/devices/force_dimension.h>
#include <kibori/devices/gamepad_device.h>
#include <kibori/devices/haply_device.h>
#include <kibori/devices/open_haptics.h>
#include <kibori/devices/recording.h>
#include <kibori/devices/vrpn_device.h>

namespace kibori {
namespace {

template <class T>
Result<std::unique_ptr<Device>> as_device(Result<std::unique_ptr<T>> opened) {
  if (!opened) return Error{opened.error()};
  return std::unique_ptr<Device>(std::move(opened).value());
}

}  // namespace

Result<std::unique_ptr<Device>> open_device(const std::string& name) {
  if (name == "forcedim") return as_device(ForceDimensionDevice::open());
  if (name == "gamepad") return as_device(GamepadDevice::open());
  if (name == "openhaptics") return as_device(OpenHapticsDevice::open());
  if (name == "haply") return as_device(HaplyDevice::open());
  if (name.rfind("haply:", 0) == 0) {
    const size_t colon = name.rfind(':');
    if (colon == 5 || colon + 1 == name.size())
      return Error{"'" + name + "' must be like haply:HOST:PORT"};
    return as_device(HaplyDevice::open(name.substr(6, colon - 6), name.substr(colon + 1)));
  }
  if (name.rfind("vrpn:", 0) == 0) {
    const Result<VrpnAddress> address = parse_vrpn_address(name.substr(5));
    if (!address) return Error{address.error()};
    return as_device(VrpnDevice::open(address.value()));
  }
  if (name == "dds" || name.starts_with("dds:")) {
    const Result<uint32_t> domain = parse_dds_domain(name);
    if (!domain) return Error{domain.error()};
    return as_device(DdsDevice::open(domain.value()));
  }
  if (name.rfind("replay:", 0) == 0) {
    Result<std::vector<RecordedReading>> readings = read_recording(name.substr(7));
    if (!readings) return Error{readings.error()};
    DeviceCapabilities capabilities;
    capabilities.name = name.substr(7) + " (replayed)";
    capabilities.dof_in = 6;
    capabilities.dof_out = 0;
    return std::unique_ptr<Device>(
        std::make_unique<ReplayDevice>(std::move(readings).value(), capabilities));
  }
  return Error{"no kind of device is called '" + name +
               "'; there are virtual, forcedim, haply[:HOST:PORT], openhaptics, gamepad, "
               "vrpn:NAME@HOST[:PORT], dds[:DOMAIN] and replay:FILE.csv"};
}

std::vector<DeviceFound> find_devices() {
  std::vector<DeviceFound> found{{"virtual", true, "a simulated hand"}};
  for (const char* name : {"forcedim", "haply", "openhaptics", "gamepad"}) {
    const Result<std::unique_ptr<Device>> device = open_device(name);
    found.push_back(
        {name, device.ok(), device ? device.value()->capabilities().name : device.error()});
  }
  found.push_back({"vrpn:NAME@HOST[:PORT]", false, "is not looked for: say which server"});
  found.push_back(
      {"dds[:DOMAIN]", false, "is not looked for: a ROS 2 program that sends /kibori/device/pose"});
  return found;
}

}  // namespace kibori
