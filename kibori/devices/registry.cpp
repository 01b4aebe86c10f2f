// SPDX-License-Identifier: MIT
#include <kibori/devices/registry.h>

#include <string_view>
#include <utility>

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

using Opened = Result<std::unique_ptr<Device>>;

// `address` is the text after "haply:", as HOST:PORT. Empty means the service on this machine.
Opened open_haply(const std::string& address) {
  if (address.empty()) return as_device(HaplyDevice::open());
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    return Error{"'haply:" + address + "' must be like haply:HOST:PORT"};
  return as_device(HaplyDevice::open(address.substr(0, colon), address.substr(colon + 1)));
}

Opened open_vrpn(const std::string& text) {
  const Result<VrpnAddress> address = parse_vrpn_address(text);
  if (!address) return Error{address.error()};
  return as_device(VrpnDevice::open(address.value()));
}

Opened open_dds(const std::string& domain) {
  const Result<uint32_t> read = parse_dds_domain(domain.empty() ? "dds" : "dds:" + domain);
  if (!read) return Error{read.error()};
  return as_device(DdsDevice::open(read.value()));
}

Opened open_replay(const std::string& path) {
  Result<std::vector<RecordedReading>> readings = read_recording(path);
  if (!readings) return Error{readings.error()};
  DeviceCapabilities capabilities;
  capabilities.name = path + " (replayed)";
  capabilities.dof_in = 6;
  capabilities.dof_out = 0;
  return std::unique_ptr<Device>(
      std::make_unique<ReplayDevice>(std::move(readings).value(), capabilities));
}

// A kind of device. `argument` is the text that may follow its name, as the help shows it. It is
// optional if it begins with '['. `open` gets the text after the colon.
struct DeviceKind {
  std::string_view name, argument;
  Opened (*open)(const std::string& argument);
  const char* not_looked_for = nullptr;  // why find_devices() does not open it; null: it does

  std::string usage() const { return std::string(name).append(argument); }
};

// All kinds except the virtual one, which needs a script. Add new kinds only here.
const DeviceKind kKinds[] = {
    {"forcedim", "", [](const std::string&) { return as_device(ForceDimensionDevice::open()); }},
    {"haply", "[:HOST:PORT]", open_haply},
    {"openhaptics", "", [](const std::string&) { return as_device(OpenHapticsDevice::open()); }},
    {"gamepad", "", [](const std::string&) { return as_device(GamepadDevice::open()); }},
    {"vrpn", ":NAME@HOST[:PORT]", open_vrpn, "is not searched for; name the server"},
    {"dds", "[:DOMAIN]", open_dds,
     "is not searched for; it needs a ROS 2 program that sends /kibori/device/pose"},
    {"replay", ":FILE.csv", open_replay, "is a recording; name the file"},
};

}  // namespace

Result<std::unique_ptr<Device>> open_device(const std::string& name) {
  const size_t colon = name.find(':');
  const std::string_view kind_name = std::string_view(name).substr(0, colon);
  std::string known = "virtual";
  for (const DeviceKind& kind : kKinds) {
    known.append(", ").append(kind.usage());
    if (kind.name != kind_name) continue;
    const bool given = colon != std::string::npos;
    // Rejects "haply:" without an address, and "forcedim:2", which has no argument.
    const bool fits = given ? !kind.argument.empty() && colon + 1 < name.size()
                            : kind.argument.empty() || kind.argument.front() == '[';
    if (!fits) return Error{"'" + name + "' must be like " + kind.usage()};
    return kind.open(given ? name.substr(colon + 1) : std::string());
  }
  return Error{"there is no kind of device '" + name + "'; there are " + known};
}

std::vector<DeviceFound> find_devices() {
  std::vector<DeviceFound> found{{"virtual", true, "a simulated hand"}};
  for (const DeviceKind& kind : kKinds) {
    if (kind.not_looked_for) {
      found.push_back({kind.usage(), false, kind.not_looked_for});
      continue;
    }
    const Opened device = kind.open({});
    found.push_back({std::string(kind.name), device.ok(),
                     device ? device.value()->capabilities().name : device.error()});
  }
  return found;
}

}  // namespace kibori
