// SPDX-License-Identifier: MIT
// Example of carving by hand: a virtual device moves a ball through a block. The program links only
// the library kibori::kibori.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include <kibori/kibori.h>

namespace {

using namespace kibori;

int fail(const std::string& what) { return std::fprintf(stderr, "%s\n", what.c_str()), 2; }

}  // namespace

int main() {
  Result<Lattice> lattice = make_lattice(Vec3(30, 20, 10), 0.25, 1);
  if (!lattice) return fail(lattice.error());
  auto model = std::make_unique<TriDexel>(lattice.value());
  model->fill_block({Vec3::Zero(), Vec3(30, 20, 10)}, 0);
  const double before = model->snapshot().volume_mm3();
  VirtualDeviceSettings device;
  device.capabilities.name = "an arm";
  device.capabilities.dof_in = device.capabilities.dof_out = 6;
  device.capabilities.force_n = 8;
  device.capabilities.force_rate_n_s = 500;
  device.capabilities.speed_mm_s = 800;
  device.capabilities.damping_ns_mm = 0.002;
  auto hand = std::make_unique<VirtualDevice>(device, [](double t) -> VirtualDevice::Target {
    return {Vec3(-30 + 60 * t, 0, 2), Mat3::Identity(), 0};
  });
  LiveSettings settings;
  settings.tool = BallTool{3};
  settings.workspace = Workspace(Vec3(15, 10, 5));
  auto live = LiveCarving::make(std::move(model), std::move(hand), settings);
  if (!live) return fail(live.error());
  double max = 0;
  for (int i = 0; i < 1000; i++) {
    const LiveTick tick = live.value()->tick(0.001);
    max = std::max(max, tick.computed.force.norm());
  }
  const double removed = before - live.value()->context().model().snapshot().volume_mm3();
  std::printf("live: removed %.3f mm3, largest force %.3f N\n", removed, max);
  return removed > 0 && max > 0 ? 0 : 1;
}
