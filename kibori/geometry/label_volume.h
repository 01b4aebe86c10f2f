// SPDX-License-Identifier: MIT
// A volume of labelled voxels, as segmented scans are, and what a label's shape is.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <kibori/geometry/vec.h>

namespace kibori {

// Numbers in the middles of voxels.
template <class T>
struct VoxelGrid {
  Index3 size = Index3::Zero();  // voxels along x, y, z
  Vec3 voxel_mm = Vec3::Ones();  // from the middle of one to that of the next
  std::vector<T> values;         // x fastest

  size_t index(int x, int y, int z) const {
    return (static_cast<size_t>(z) * static_cast<size_t>(size.y()) + static_cast<size_t>(y)) *
               static_cast<size_t>(size.x()) +
           static_cast<size_t>(x);
  }
  bool holds(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size.x() && y < size.y() && z < size.z();
  }
  T at(int x, int y, int z, T outside) const {
    return holds(x, y, z) ? values[index(x, y, z)] : outside;
  }
  Vec3 size_mm() const { return size.matrix().cast<double>().cwiseProduct(voxel_mm); }
};

struct LabelVolume : VoxelGrid<uint16_t> {  // 0: air
  std::map<uint16_t, std::string> names;    // of labels, where the file has them
};

// From -1, far outside, to 1, far within; outside the grid it is -1. A shape is where the trilinear
// interpolation is above 0.
using ShapeGrid = VoxelGrid<float>;

// The shape of the labels that `is_of` takes. Steps of voxels are smoothed away as far as the
// voxels leave it open: the middle of each is on its own side, so that faces are within half a
// voxel of where they were, and round faces keep their place (sqrt(2) G - G G, G binomial of
// variance 2: what each does to a face of any radius cancels). It takes 8 bytes a voxel meanwhile,
// 4 at the end.
ShapeGrid shape_of_labels(const LabelVolume& volume, const std::function<bool(uint16_t)>& is_of);

// The labels that a volume has, rising; air is none.
std::vector<uint16_t> labels_of(const LabelVolume& volume);

// The shapes of all labels of a volume, so that each place of the whole is of one: of the label
// whose own shape is strongest there. It keeps 10 bytes a voxel; each label takes a pass over all.
class LabelShapes {
 public:
  // `volume` must outlive it.
  explicit LabelShapes(const LabelVolume& volume);

  // All that is no air.
  ShapeGrid whole() const;
  // Of the whole, what is of that label; beyond the whole it says nothing.
  ShapeGrid share_of(uint16_t label) const;

 private:
  const LabelVolume& volume_;
  std::vector<uint16_t> labels_;
  // Of each voxel: which label is strongest there, how strong it is, and the next.
  std::vector<uint16_t> winner_;
  std::vector<float> first_, second_;
};

}  // namespace kibori
