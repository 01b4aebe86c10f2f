// SPDX-License-Identifier: MIT
// A volume of voxels with labels, for example a segmented scan. Computes the shapes of the labels.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <kibori/geometry/vec.h>

namespace kibori {

// A grid of voxels, with one number for the centre of each voxel.
template <class T>
struct VoxelGrid {
  Index3 size = Index3::Zero();  // number of voxels along x, y, z
  Vec3 voxel_mm = Vec3::Ones();  // distance between the centres of adjacent voxels
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

struct LabelVolume : VoxelGrid<uint16_t> {  // label 0 is air
  std::map<uint16_t, std::string> names;    // of the labels, if the file has names
};

// A shape, as numbers from -1 (far outside) to 1 (far inside). Outside the grid, the numbers count
// as -1. A point is in the shape if the trilinear interpolation of the numbers is above 0.
using ShapeGrid = VoxelGrid<float>;

// Returns the shape of all labels that `is_of` accepts. A filter smooths the steps between voxels.
// The centre of each voxel stays on its side of the surface, so faces move by less than half a
// voxel. The filter is (sqrt(2) G - G G) / (sqrt(2) - 1). G is a binomial filter whose variance is
// 2. Alone, G or G G would move a round face. Here, the two displacements cancel, so round faces
// keep their position. The function uses 8 bytes per voxel while it runs. The result uses 4.
ShapeGrid shape_of_labels(const LabelVolume& volume, const std::function<bool(uint16_t)>& is_of);

// Returns the labels of a volume in ascending order, without 0 (air).
std::vector<uint16_t> labels_of(const LabelVolume& volume);

// The shapes of all labels of a volume, without overlaps. Each place inside belongs to the label
// whose own shape (shape_of_labels) has the largest number there. The constructor computes the own
// shape of each label. An object uses 10 bytes per voxel.
class LabelShapes {
 public:
  // `volume` must outlive this object.
  explicit LabelShapes(const LabelVolume& volume);

  // Returns the shape of everything except air.
  ShapeGrid whole() const;
  // Returns the part of whole() that belongs to the label. Outside whole(), the numbers have no
  // meaning.
  ShapeGrid share_of(uint16_t label) const;

 private:
  const LabelVolume& volume_;
  std::vector<uint16_t> labels_;
  // For each voxel: the label whose own shape has the largest number, that number, and the second
  // largest number of all labels.
  std::vector<uint16_t> winner_;
  std::vector<float> first_, second_;
};

}  // namespace kibori
