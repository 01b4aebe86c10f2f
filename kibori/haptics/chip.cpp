// SPDX-License-Identifier: MIT
#include <kibori/haptics/chip.h>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kibori {
namespace {

// Minimum width of a chip, divided by the square root of its section. It matters only for chips
// that are about as wide as thick: this quotient is 0.98 for a disc and 1 for a square.
constexpr double kMinWidth = 0.9;
// Length of the displacement divided by that of the path. Below kSpins the tool only spins, above
// kMoves it moves. In between, chip_of blends both laws, so that the force does not jump.
constexpr double kSpins = 0.5, kMoves = 0.7;
constexpr double kMaxFront = 2;
constexpr double kMaxGap = 0.95;
// Gaps smaller than this [cells] count less, because a single empty cell is often an accident of
// the rays. With a smaller value, such a cell makes the force jump. With a larger one, narrow gaps
// count as material.
constexpr double kSureGap = 3;
// Path [cells] over which PathMean::gaps collects cells, on average.
constexpr double kGapPath = 1.5;

// Share of the chip's width that is empty. `across2`, `along2`, `thin2`: squares of the components
// of the wide direction, of the motion and of the thin direction. If the chip is oblique to an
// axis, its thickness and its path also cover cells along this axis. So the gap between two patches
// seems narrower than it is, and this function adds a correction. The correction starts at zero for
// a gap of zero, so that the width does not jump.
double gap_share(const Vec3& gaps, const Vec3& across2, const Vec3& along2, const Vec3& thin2,
                 double wide, double thick, double path) {
  double gap = std::clamp(across2.dot(gaps), 0.0, kMaxGap);
  if (!(gap > 0)) return 0;
  for (int pass = 0; pass < 2; pass++) {
    const double width = wide / std::sqrt(1 + gap + gap * gap);
    double sum = 0, weights = 0;
    for (int i = 0; i < 3; i++) {
      const double own = width * std::sqrt(std::max(0.0, across2[i]));
      const double more = thick * std::sqrt(std::max(0.0, thin2[i])) + path * std::sqrt(along2[i]);
      double empty = gaps[i] * (own + more);
      empty *= std::min(1.0, empty / kSureGap);
      // The axis that is nearest to the wide direction counts most: the gap is widest there.
      const double weight = across2[i] * across2[i];
      weights += weight;
      const double hidden = empty < more ? empty * empty / more : more;
      if (own > 0) sum += weight * std::min(kMaxGap, (empty + hidden) / own);
    }
    gap = weights > 0 ? sum / weights : 0;
  }
  return gap;
}

}  // namespace

void ChipMoments::add(const ChipMoments& other, double times) {
  volume += times * other.volume;
  first += times * other.first;
  for (size_t i = 0; i < 6; i++) second[i] += times * other.second[i];
  displacement += times * other.displacement;
  path += times * other.path;
  front += times * other.front;
  front_normal += times * other.front_normal;
  section += times * other.section;
  length += times * other.length;
}

Chip chip_of(const ChipMoments& sums, double cells, double pitch_mm, const Vec3& gaps) {
  Chip chip;
  if (!(sums.volume > 0 && sums.section > 0 && cells > 0)) return chip;
  const double section = sums.section / cells;  // [cells^2]
  const Vec3 mean = sums.first / sums.volume;
  const auto& q = sums.second;
  Mat3 covariance;
  covariance << q[0], q[3], q[4],  //
      q[3], q[1], q[5],            //
      q[4], q[5], q[2];
  covariance = covariance / sums.volume - mean * mean.transpose();
  const double distance = std::sqrt(sums.displacement.squaredNorm());
  if (distance > 0 && sums.path > 0) {
    chip.direction = sums.displacement / distance;
    chip.moves = std::clamp((distance / sums.path - kSpins) / (kMoves - kSpins), 0.0, 1.0);
  }
  const double min_width = kMinWidth * std::sqrt(section);
  double width = min_width;
  if (chip.moves < 1) {
    const Eigen::SelfAdjointEigenSolver<Mat3> solved(covariance, Eigen::EigenvaluesOnly);
    width = std::max(width, std::sqrt(12 * std::max(0.0, solved.eigenvalues()[2])));
  }
  if (chip.moves > 0) {
    const Mat3 across = Mat3::Identity() - chip.direction * chip.direction.transpose();
    const Mat3 flat = across * covariance * across;
    const double trace = flat.trace();
    if (trace > 0) {
      // One eigenvalue of this symmetric matrix is 0. These lines compute the larger of the other
      // two.
      const double half = 0.5 * trace;
      const double difference = std::sqrt(std::max(0.0, 0.5 * flat.squaredNorm() - half * half));
      const double apart = std::min(half, difference);
      double wide = std::sqrt(12 * (half + apart));
      if (difference > 0) {
        // Squares of the components of the wide direction.
        const Vec3 across2 = (flat - (half - difference) * across).diagonal() / (2 * difference);
        const Vec3 along2 = chip.direction.cwiseAbs2();
        const double thick = std::sqrt(12 * std::max(0.0, half - apart));
        const double path =
            std::sqrt(12 * std::max(0.0, chip.direction.dot(covariance * chip.direction)));
        const double gap = gap_share(gaps, across2, along2, Vec3(Vec3::Ones() - across2 - along2),
                                     wide, thick, path + kGapPath);
        wide *= (1 - gap) / std::sqrt(1 + gap + gap * gap);
      }
      wide = std::max(min_width, wide);
      width = chip.moves < 1 ? width + chip.moves * (wide - width) : wide;
      // `apart` treats a negative eigenvalue as 0, so that D stays within [-1, 1].
      if (apart > 0) chip.flatness = apart / (half * difference) * (flat - half * across);
    }
  }
  chip.section_mm2 = section * pitch_mm * pitch_mm;
  chip.width_mm = width * pitch_mm;
  chip.thickness_mm = chip.section_mm2 / chip.width_mm;
  if (sums.front > 0 && chip.moves > 0) {
    Vec3 front = sums.front_normal / sums.front;
    front -= front.dot(chip.direction) * chip.direction;
    const double size = std::sqrt(front.squaredNorm());
    chip.front = chip.moves * (size > kMaxFront ? Vec3(kMaxFront / size * front) : front);
  }
  return chip;
}

Chip with_section(const Chip& shape, double section_mm2) {
  Chip chip = shape;
  chip.section_mm2 = section_mm2;
  chip.width_mm = std::max(shape.width_mm, kMinWidth * std::sqrt(section_mm2));
  chip.thickness_mm = section_mm2 / chip.width_mm;
  return chip;
}

double thickness_factor(double thickness_mm, double m) {
  return thickness_mm < 1 ? std::pow(thickness_mm, 1 - m) : 1 + (1 - m) * (thickness_mm - 1);
}

double cutting_energy(const Material& material, const Chip& chip, const Vec3* fibre) {
  if (!has_chip_law(material)) return material.u;
  const auto [end, along, across] = material.k;
  double k = (end + along + across) / 3;
  if (fibre && chip.moves > 0 && has_direction(material)) {
    const double cos = fibre->dot(chip.direction);
    const Vec3 normal = *fibre - cos * chip.direction;
    const double directed = along * cos * cos + 0.5 * (end + across) * normal.squaredNorm() +
                            0.5 * (across - end) * normal.dot(chip.flatness * normal);
    k += chip.moves * (directed - k);
  }
  if (!(chip.section_mm2 > 0)) return k;
  return k * chip.width_mm * thickness_factor(chip.thickness_mm, material.m) / chip.section_mm2;
}

}  // namespace kibori
