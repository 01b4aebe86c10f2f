// SPDX-License-Identifier: MIT
#include <kibori/geometry/label_volume.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace kibori {
namespace {

// Passes of the binomial filter, with variance 1 each [voxels^2]. With more passes, a layer that is
// five voxels thin becomes thicker. With fewer, inclined faces keep ripples.
constexpr int kPasses = 2;
// One smoothing moves a face of radius R by variance / R. Two smoothings move it twice as far, and
// make the field flatter by the factor kOnce. Therefore, kOnce times the first, minus the second,
// leaves the face in place.
constexpr float kOnce = std::numbers::sqrt2_v<float>;
// If smoothing moves the centre of a voxel from inside to outside, or back, the value changes its
// sign. So the voxel stays inside or outside. These are limits for the size of the new value:
// kMinKept so that it is not zero, kMaxKept because this keeps walls that are one voxel thin.
constexpr float kMinKept = 0.02f, kMaxKept = 0.3f;

// Filters each line along an axis by [1 4 6 4 1] / 16, `passes` times. Each line is extended by the
// values beyond the grid that affect the result. They are -1 at first.
void smooth_along(int axis, int passes, const ShapeGrid& grid, std::vector<float>& values) {
  const std::array<size_t, 3> stride{
      1, static_cast<size_t>(grid.size.x()),
      static_cast<size_t>(grid.size.x()) * static_cast<size_t>(grid.size.y())};
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  const auto count = static_cast<size_t>(grid.size[axis]);
  const size_t step = stride[static_cast<size_t>(axis)], beyond = 2 * static_cast<size_t>(passes);
  std::vector<float> line(count + 2 * beyond), next = line;
  for (int j = 0; j < grid.size[b]; j++)
    for (int i = 0; i < grid.size[a]; i++) {
      float* const from = values.data() + static_cast<size_t>(i) * stride[static_cast<size_t>(a)] +
                          static_cast<size_t>(j) * stride[static_cast<size_t>(b)];
      std::fill(line.begin(), line.end(), -1.0f);
      for (size_t k = 0; k < count; k++) line[k + beyond] = from[k * step];
      // Each pass makes the line shorter by two values at each end.
      for (size_t pass = 1; pass <= static_cast<size_t>(passes); pass++) {
        for (size_t k = 2 * pass; k + 2 * pass < line.size(); k++)
          next[k] =
              (line[k - 2] + 4 * line[k - 1] + 6 * line[k] + 4 * line[k + 1] + line[k + 2]) / 16;
        std::swap(line, next);
      }
      for (size_t k = 0; k < count; k++) from[k * step] = line[k + beyond];
    }
}

void smooth(int passes, const ShapeGrid& grid, std::vector<float>& values) {
  for (int axis = 0; axis < 3; axis++) smooth_along(axis, passes, grid, values);
}

}  // namespace

ShapeGrid shape_of_labels(const LabelVolume& volume, const std::function<bool(uint16_t)>& is_of) {
  ShapeGrid shape{volume.size, volume.voxel_mm, {}};
  std::vector<bool> takes(size_t{1} << 16);
  for (size_t label = 0; label < takes.size(); label++)
    takes[label] = is_of(static_cast<uint16_t>(label));
  shape.values.reserve(volume.values.size());
  for (const uint16_t label : volume.values) shape.values.push_back(takes[label] ? 1.0f : -1.0f);
  std::vector<float> twice = shape.values;
  smooth(kPasses, shape, shape.values);
  smooth(2 * kPasses, shape, twice);
  for (size_t i = 0; i < twice.size(); i++) {
    float& value = shape.values[i];
    value = std::clamp((kOnce * value - twice[i]) / (kOnce - 1), -1.0f, 1.0f);
    const bool within = takes[volume.values[i]];
    if (within == (value > 0)) continue;
    const float kept = std::clamp(std::abs(value), kMinKept, kMaxKept);
    value = within ? kept : -kept;
  }
  return shape;
}

std::vector<uint16_t> labels_of(const LabelVolume& volume) {
  std::vector<bool> there(size_t{1} << 16);
  for (const uint16_t label : volume.values) there[label] = true;
  std::vector<uint16_t> labels;
  for (size_t label = 1; label < there.size(); label++)
    if (there[label]) labels.push_back(static_cast<uint16_t>(label));
  return labels;
}

LabelShapes::LabelShapes(const LabelVolume& volume) : volume_(volume), labels_(labels_of(volume)) {
  if (labels_.size() < 2) return;
  first_.assign(volume.values.size(), -2);
  second_ = first_;
  winner_.resize(volume.values.size());
  for (const uint16_t label : labels_) {
    const ShapeGrid shape = shape_of_labels(volume, [&](uint16_t l) { return l == label; });
    for (size_t i = 0; i < shape.values.size(); i++) {
      const float value = shape.values[i];
      if (value > first_[i]) {
        second_[i] = first_[i];
        first_[i] = value;
        winner_[i] = label;
      } else if (value > second_[i]) {
        second_[i] = value;
      }
    }
  }
}

ShapeGrid LabelShapes::whole() const {
  return shape_of_labels(volume_, [](uint16_t label) { return label != 0; });
}

ShapeGrid LabelShapes::share_of(uint16_t label) const {
  ShapeGrid shape = shape_of_labels(volume_, [&](uint16_t l) { return l == label; });
  if (labels_.size() < 2) return shape;
  for (size_t i = 0; i < shape.values.size(); i++)
    shape.values[i] -= winner_[i] == label ? second_[i] : first_[i];
  return shape;
}

}  // namespace kibori
