// SPDX-License-Identifier: MIT
// All kinds of devices. Opens a device by its name, and searches for connected devices.
// docs/devices.md describes the kinds and the names. The kind `virtual` is not opened here, because
// it needs a script. The session makes it. CONTRIBUTING.md explains how to add a kind.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

// Opens a device. Errors: there is no such kind; the name does not fit the kind; the device cannot
// be opened.
Result<std::unique_ptr<Device>> open_device(const std::string& name);

// The result of the search for one kind of device.
struct DeviceFound {
  std::string name;  // the name for open_device()
  bool present = false;
  std::string text;  // a description of the device, or the reason why it is missing
};
// Tries to open a device of each kind that needs no address. Closes it again.
std::vector<DeviceFound> find_devices();

}  // namespace kibori
