// SPDX-License-Identifier: MIT
// A volume of labelled voxels, for example a segmented scan, and the shapes of its labels.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <kibori/geometry/vec.h>

namespace kibori {

// Numbers at the centres of voxels.
template <class T>
struct VoxelGrid {
  Index3 size = Index3::Zero();  // voxels along x, y, z
  Vec3 voxel_mm = Vec3::Ones();  // distance between the centres of neighbours
  std::vector<T> values;         // x is the fastest index

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
  std::map<uint16_t, std::string> names;    // of labels, if the file has them
};

// Values from -1, far outside a shape, to 1, far inside. Outside the grid they are -1. The shape
// consists of the points where the trilinear interpolation is above 0.
using ShapeGrid = VoxelGrid<float>;

// The shape of the labels that `is_of` accepts. The steps between voxels are smoothed. The centre
// of each voxel stays inside or outside, so faces move by less than half a voxel. Round faces keep
// their position. The filter is sqrt(2) G - G G, where G is a binomial filter of variance 2. Each
// of the two terms would move a round face, but their displacements cancel. The function uses 8
// bytes per voxel while it runs. The result uses 4.
ShapeGrid shape_of_labels(const LabelVolume& volume, const std::function<bool(uint16_t)>& is_of);

// The labels of a volume in ascending order, without air.
std::vector<uint16_t> labels_of(const LabelVolume& volume);

// The shapes of all labels of a volume. Each place inside belongs to one label: the one whose own
// shape (shape_of_labels) has the largest value there. An object keeps 10 bytes per voxel. The
// constructor makes the shape of each label once.
class LabelShapes {
 public:
  // `volume` must outlive this object.
  explicit LabelShapes(const LabelVolume& volume);

  // The shape of everything except air.
  ShapeGrid whole() const;
  // The part of the whole that belongs to the label. Outside the whole, the values have no meaning.
  ShapeGrid share_of(uint16_t label) const;

 private:
  const LabelVolume& volume_;
  std::vector<uint16_t> labels_;
  // Per voxel: the label with the largest value, this value, and the second largest value.
  std::vector<uint16_t> winner_;
  std::vector<float> first_, second_;
};

}  // namespace kibori
