// SPDX-License-Identifier: MIT
// All kinds of devices: opening one by name, and what of them is there.
//
//   virtual                    a simulated hand (the session makes it: it needs a script)
//   forcedim                   Force Dimension devices and the Novint Falcon
//   haply[:HOST:PORT]          Haply Inverse3, through its service on this machine or another
//   openhaptics                3D Systems' Touch family
//   gamepad                    a game controller that rumbles
//   vrpn:NAME@HOST[:PORT]      anything behind a VRPN server
//   dds[:DOMAIN]               a program that sends poses as ROS 2 does
//   replay:FILE.csv            a recording: the hand's way again
//
// A new kind is a class of its own (haptics/device.h) and one row of the list in registry.cpp.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/haptics/device.h>

namespace kibori {

// Errors: an unknown kind, or why it can't be opened.
Result<std::unique_ptr<Device>> open_device(const std::string& name);

struct DeviceFound {
  std::string name;  // for open_device
  bool present = false;
  std::string text;  // what it is, or why it is not there
};
// Looks for each kind that can be looked for, opening and closing it.
std::vector<DeviceFound> find_devices();

}  // namespace kibori
