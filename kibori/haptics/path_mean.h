// SPDX-License-Identifier: MIT
// The sliding mean over one cell of path. It converts removed volume into a steady force.
//
// The removed volume varies from tick to tick, because whole rows of rays enter a flat tool at
// once. The mean over one cell of path varies little. So the volume of each tick is "paid" evenly
// over the next cell of path: in each tick, the paid volume resists the tool. The path can be
// divided into ticks of any length. Consequences:
//
// - the work of a stroke is proportional to its removed volume, once all of it is paid;
// - a force is late by half a cell on average, and ends one cell after the last removal;
// - a negative volume is not paid but carried over: the force never drives the tool forward.
//
// The unpaid volume is dropped when the tool reverses or its stroke ends. never_paid() reports it.
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

  // Resistance of one material in a tick, in lattice units, with moments about the tip.
  struct Resistance {
    double volume = 0;          // weighted by the ratio of resistance to u
    Vec3 lever = Vec3::Zero();  // first moment of that volume
    // If the tool turns, each element resists its own displacement s: f = dV s/|s|^2.
    Vec3 force = Vec3::Zero();        // f
    Vec3 moment = Vec3::Zero();       // r x f
    Vec3 moment_axis = Vec3::Zero();  // moment of the lever's part along the tool (5 dof)
    bool has_chip = false;            // only if the law needs the chip's shape
    ChipMoments chip;                 // zero without has_chip

    void add(const Resistance& other, double times);
  };

  // Adds the resistance of a tick over a path of `cells` > 0 in one material. Call pay()
  // afterwards.
  void put(int material, const Resistance& what, double cells);
  // Adds the cells in which a tick over a path of `cells` removed something.
  void put_cells(const std::array<CellSet, 3>& met, double cells);
  // Share of empty cells between the first and the last non-empty cell, along x, y and z. It covers
  // the last one to two cells of path, because in a single tick a thin chip meets too few rays.
  Vec3 gaps() const;
  // Advances by the tick's path and pays what is due in this tick.
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
  // Calls f(material, resistance) for each material of which the last pay() paid a volume above 0.
  template <class F>
  void for_paid(F&& f) const {
    for (uint64_t left = paid_; left; left &= left - 1) {
      const int material = std::countr_zero(left);
      f(material, (*windows_)[static_cast<size_t>(material)].now);
    }
  }
  // Volume that is still unpaid [cells^3], weighted as in Resistance.
  double unpaid() const;
  // Drops the unpaid volume and restarts the path.
  void drop();
  // All volume that was dropped so far, plus the unpaid volume.
  double never_paid() const { return dropped_ + unpaid(); }

 private:
  // A tick's path counts at most 4 cells. Everything older is paid after that, so a few bins are
  // enough.
  static double counted(double cells) { return cells < 4 ? cells : 4; }
  // The path is divided into bins, and the volume of a bin counts as spread evenly over it. More
  // bins take more time. With fewer bins, the mean extends over more than a cell.
  static constexpr int kBinsPerCell = 8;
  static constexpr int kBins = 16;  // two cells of path, so that a bin is paid before its reuse
  struct Bin {
    bool used = false;
    int64_t number = 0;
    double paid = 0;  // share of the bin that is paid, 0 to 1
    Resistance left;  // unpaid; force, moments and section are multiplied by the tick's path
  };
  struct Window {
    std::array<Bin, kBins> bins;
    Resistance carried;  // to be paid at once, unless its volume is below 0
    Resistance now;      // paid by the last pay()
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
