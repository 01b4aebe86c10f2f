// SPDX-License-Identifier: MIT
// All kinds of devices. Opens one by name, and searches for connected ones. docs/devices.md
// describes the kinds and their names. The kind `virtual` is not opened here: the session makes it,
// because it needs a script. CONTRIBUTING.md says how to add a kind.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

// Errors: an unknown kind, or the reason why it cannot be opened.
Result<std::unique_ptr<Device>> open_device(const std::string& name);

// A kind of device, and whether one is connected.
struct DeviceFound {
  std::string name;  // for open_device
  bool present = false;
  std::string text;  // what it is, or why it is missing
};
// Tries to open a device of each kind that needs no address, and closes it again.
std::vector<DeviceFound> find_devices();

}  // namespace kibori
