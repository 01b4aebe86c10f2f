// SPDX-License-Identifier: MIT
// A block of 40 x 30 x 20 mm under a virtual device, for tests.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include <kibori/devices/virtual_device.h>
#include <kibori/live/live_carving.h>

namespace kibori::test {

inline DeviceCapabilities arm() {
  DeviceCapabilities c;
  c.name = "an arm";
  c.dof_in = c.dof_out = 6;
  c.force_n = 8;
  c.torque_nmm = 100;
  c.force_rate_n_s = 500;
  c.torque_rate_nmm_s = 5000;
  c.speed_mm_s = 800;
  c.damping_ns_mm = 0.002;
  return c;
}

inline std::unique_ptr<TriDexel> block(double pitch) {
  auto model = std::make_unique<TriDexel>(make_lattice(Vec3(40, 30, 20), pitch, 10).value());
  model->fill_block({Vec3::Zero(), Vec3(40, 30, 20)}, 0);
  return model;
}

struct Rig {
  VirtualDevice* device;
  std::unique_ptr<LiveCarving> live;
};

// A virtual device over the block, or over `model`. The device's centre is 5 mm above the middle of
// the top.
inline Rig rig(const VirtualDeviceSettings& device, LiveSettings settings,
               VirtualDevice::Script script, std::unique_ptr<TriDexel> model = nullptr) {
  auto made = std::make_unique<VirtualDevice>(device, std::move(script));
  VirtualDevice* const kept = made.get();
  settings.workspace = Workspace(Vec3(20, 15, 25));
  auto live = LiveCarving::make(model ? std::move(model) : block(0.5), std::move(made), settings);
  EXPECT_TRUE(live.ok()) << live.error();
  return {kept, std::move(live).value()};
}

inline VirtualDevice::Target down(double z) { return {Vec3(0, 0, z), Mat3::Identity(), 0}; }

}  // namespace kibori::test
