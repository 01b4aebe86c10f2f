// SPDX-License-Identifier: MIT
// A sliding mean over one cell of path. It converts removed volumes into a steady force.
//
// The removed volume varies from tick to tick, because whole rows of rays enter a flat tool at the
// same moment. Its mean over one cell of path varies little. Therefore, the volume of each tick is
// "paid" evenly over the next cell of path. In each tick, the paid volume resists the tool. The
// result does not depend on the division of the path into ticks. Consequences:
//
// - The work of a stroke is proportional to its removed volume, as soon as all of it is paid.
// - A force is late by half a cell on average. It ends one cell after the last removal.
// - A negative volume is not paid but carried over, so the force never drives the tool forward.
//
// The unpaid volume is dropped when the tool reverses or the stroke ends. never_paid() returns the
// volume that was dropped and the volume that is unpaid.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>

#include <kibori/base/tolerances.h>
#include <kibori/edit/removed.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/chip.h>

namespace kibori {

class PathMean {
 public:
  PathMean() : windows_(std::make_unique<std::array<Window, kMaxMaterials>>()) {}

  // The resistance of one material in a tick, in lattice units. Moments are about the tip.
  struct Resistance {
    double volume = 0;          // weighted: force of the material / force by its u
    Vec3 lever = Vec3::Zero();  // first moment of `volume`
    // If the tool turns, each element resists against its own displacement s: f = dV s/|s|^2.
    Vec3 force = Vec3::Zero();        // sum of f
    Vec3 moment = Vec3::Zero();       // sum of r x f
    Vec3 moment_axis = Vec3::Zero();  // moment of the part of the lever along the tool (dof 5)
    bool has_chip = false;            // true only if the law needs the chip's shape
    ChipMoments chip;                 // zero without has_chip

    void add(const Resistance& other, double times);
  };

  // Adds the resistance of one material in a tick. `cells` is the path of the tick, above 0. Call
  // pay() after all materials.
  void put(int material, const Resistance& what, double cells);
  // Adds the cells in which the tick removed material. `cells` is the path of the tick.
  void put_cells(const std::array<CellSet, 3>& met, double cells);
  // Returns the share of empty cells between the first and the last non-empty cell, along x, y and
  // z. The share is over the last one to two cells of path, because a thin chip meets too few rays
  // in one tick.
  Vec3 gaps() const;
  // Advances by the path of the tick, and pays what is due.
  void pay(double cells) {
    at_ += counted(cells);
    paid_ = 0;
    for (uint64_t left = materials_; left; left &= left - 1) {
      const int material = std::countr_zero(left);
      Window& window = (*windows_)[static_cast<size_t>(material)];
      window.now = pay_of(material, cells);
      if (window.now.volume > 0) paid_ |= uint64_t{1} << material;
    }
  }
  // Calls f(material, resistance) for each material for which the last pay() paid a volume above 0.
  template <class F>
  void for_paid(F&& f) const {
    for (uint64_t left = paid_; left; left &= left - 1) {
      const int material = std::countr_zero(left);
      f(material, (*windows_)[static_cast<size_t>(material)].now);
    }
  }
  // Returns the volume that is not paid yet [cells^3], weighted as in Resistance.
  double unpaid() const;
  // Drops the unpaid volume and restarts the path.
  void drop();
  // Returns all volume that was dropped so far, plus the unpaid volume.
  double never_paid() const { return dropped_ + unpaid(); }

 private:
  // The path of a tick counts as at most 4 cells. After 4 cells, everything older is paid, so a few
  // bins are enough.
  static double counted(double cells) { return cells < 4 ? cells : 4; }
  // The path is divided into bins. The volume of a bin counts as evenly distributed over the bin.
  // With more bins, a tick takes longer. With fewer bins, the mean extends over more than one cell.
  static constexpr int kBinsPerCell = 8;
  static constexpr int kBins = 16;  // two cells: each bin is paid before it is used again
  struct Bin {
    bool used = false;
    int64_t number = 0;
    double paid = 0;  // share of the bin that is paid, 0 to 1
    Resistance left;  // unpaid; force, moments and section are multiplied by the path of the tick
  };
  struct Window {
    std::array<Bin, kBins> bins;
    Resistance carried;  // paid in the next tick, unless its volume is below 0
    Resistance now;      // what the last pay() paid
  };
  Resistance pay_of(int material, double cells);

  std::unique_ptr<std::array<Window, kMaxMaterials>> windows_;
  uint64_t materials_ = 0;  // bit i: material i has unpaid volume
  uint64_t paid_ = 0;
  std::array<CellSet, 3> recent_{}, older_{};
  double recent_cells_ = 0;  // path over which `recent_` was collected
  double at_ = 0;            // [cells] path since the last drop()
  double dropped_ = 0;       // [cells^3]
};

}  // namespace kibori
