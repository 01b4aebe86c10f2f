// SPDX-License-Identifier: MIT
// All kinds of devices. Opens one by name, and searches for connected ones.
//
//   virtual                    a simulated hand (the session makes it: it needs a script)
//   forcedim                   Force Dimension devices and the Novint Falcon
//   haply[:HOST:PORT]          Haply Inverse3, through its service on this machine or another
//   openhaptics                3D Systems' Touch family
//   gamepad                    a game controller that rumbles
//   vrpn:NAME@HOST[:PORT]      any device behind a VRPN server
//   dds[:DOMAIN]               a program that sends poses as ROS 2 does
//   replay:FILE.csv            a recording of a hand's motion
//
// A new kind needs a class (haptics/device.h) and one row of the list in registry.cpp.
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
// Opens and closes each kind that can be searched.
std::vector<DeviceFound> find_devices();

}  // namespace kibori
