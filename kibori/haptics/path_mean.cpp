// SPDX-License-Identifier: MIT
#include <kibori/haptics/path_mean.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// Integral of min(y, 1), which is the share of a volume that is paid y cells after its removal.
double integral(double y) {
  if (!(y > 0)) return 0;
  return y < 1 ? 0.5 * y * y : y - 0.5;
}

}  // namespace

void PathMean::Resistance::add(const Resistance& other, double times) {
  volume += times * other.volume;
  lever += times * other.lever;
  force += times * other.force;
  moment += times * other.moment;
  moment_axis += times * other.moment_axis;
  if (!other.has_chip) return;
  has_chip = true;
  chip.add(other.chip, times);
}

void PathMean::put(int material, const Resistance& what, double cells) {
  Window& window = (*windows_)[static_cast<size_t>(material)];
  if (!((materials_ >> material) & 1)) {
    for (Bin& bin : window.bins) bin.used = false;
    window.carried = {};
    materials_ |= uint64_t{1} << material;
  }
  Resistance by_path = what;
  by_path.force *= cells;
  by_path.moment *= cells;
  by_path.moment_axis *= cells;
  by_path.chip.section *= cells;
  const double begin = at_, end = at_ + counted(cells);
  // The volume that was removed more than a cell before the tick's end is paid at once.
  const double from = std::max(begin, std::floor((end - 1) * kBinsPerCell) / kBinsPerCell);
  if (from > begin) window.carried.add(by_path, 1 - (end - from) / cells);
  for (auto number = static_cast<int64_t>(std::floor(from * kBinsPerCell));; number++) {
    const double low = static_cast<double>(number) / kBinsPerCell;
    if (!(low < end)) break;
    const double high = static_cast<double>(number + 1) / kBinsPerCell;
    Bin& bin = window.bins[static_cast<size_t>(number % kBins)];
    if (bin.used && bin.number != number) {
      window.carried.add(bin.left, 1);
      bin.used = false;
    }
    if (!bin.used) bin = {true, number, 0, {}};
    bin.left.add(by_path, (std::min(end, high) - std::max(from, low)) / cells);
  }
}

void PathMean::put_cells(const std::array<CellSet, 3>& met, double cells) {
  if (recent_cells_ >= 1) {
    older_ = recent_;
    recent_ = {};
    recent_cells_ = 0;
  }
  for (size_t i = 0; i < 3; i++) recent_[i].add(met[i]);
  recent_cells_ += cells;
}

Vec3 PathMean::gaps() const {
  Vec3 shares;
  for (size_t i = 0; i < 3; i++) {
    CellSet all = recent_[i];
    all.add(older_[i]);
    shares[static_cast<int>(i)] = all.gaps();
  }
  return shares;
}

PathMean::Resistance PathMean::pay_of(int material, double cells) {
  Window& window = (*windows_)[static_cast<size_t>(material)];
  Resistance now = window.carried;
  bool any = false;
  for (Bin& bin : window.bins) {
    if (!bin.used) continue;
    const double since = at_ - static_cast<double>(bin.number) / kBinsPerCell;
    const double paid =
        std::min(1.0, kBinsPerCell * (integral(since) - integral(since - 1.0 / kBinsPerCell)));
    const double part = paid < 1 ? (paid - bin.paid) / (1 - bin.paid) : 1;
    now.add(bin.left, part);
    bin.left.add(bin.left, -part);
    bin.paid = paid;
    bin.used = paid < 1;
    any |= bin.used;
  }
  const bool negative = !(now.volume > 0);
  window.carried = negative ? now : Resistance{};
  if (!any && !(negative && now.volume < 0)) materials_ &= ~(uint64_t{1} << material);
  if (negative) return {};
  now.force /= cells;
  now.moment /= cells;
  now.moment_axis /= cells;
  return now;
}

void PathMean::drop() {
  dropped_ += unpaid();
  materials_ = paid_ = 0;
  at_ = 0;
  recent_ = older_ = {};
  recent_cells_ = 0;
}

double PathMean::unpaid() const {
  double sum = 0;
  for (uint64_t left = materials_; left; left &= left - 1) {
    const Window& window = (*windows_)[static_cast<size_t>(std::countr_zero(left))];
    sum += window.carried.volume;
    for (const Bin& bin : window.bins)
      if (bin.used) sum += bin.left.volume;
  }
  return sum;
}

}  // namespace kibori
