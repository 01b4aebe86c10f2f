// SPDX-License-Identifier: MIT
// Parametric strokes: the surface as it was when the stroke began, taken elsewhere by a WarpMap.
// Always from that beginning, so the same parameters make the same model, whatever came between;
// back at the beginning, the model is the first one again, bit for bit.
//
// The surface's triangles (surface.h) are moved, those that stretch are split, and the rays that
// they cross are told anew. Sharp edges stay sharp. Rays that no moved triangle crosses keep their
// spans. The three fields agree: the z field decides the nodes, the other two only where between
// them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>
#include <kibori/reshape/warp_map.h>
#include <kibori/surface/surface.h>

namespace kibori {

class Warp {
 public:
  // A stroke begins on the model as it is now. Until the next begin(), nobody else may change it.
  explicit Warp(TriDexel& model) : model_(model) {}
  void begin();
  // On how many threads it is warped; results do not depend on it.
  void set_threads(int threads) { threads_ = threads; }

  // The model as it was at begin(), warped; what changed is told against that model. Drags in mm,
  // of the hand and its images; where several reach a point, their displacements add up. Errors: a
  // brush that check_brush refuses, a drag that is not finite or is longer than kMaxDragRadii, a
  // region of more nodes than there is memory for: then the model stays as it is.
  Result<Reshaped> warp(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags);

  static constexpr double kMaxDragRadii = 100;

 private:
  struct Vertex {
    Vec3 at;
    std::array<float, 3> normal;
    uint8_t material;
    Color paint;
  };
  // A moved triangle's crossing with a ray.
  struct Crossing {
    uint64_t ray;  // see ray_key
    double depth;
    bool out;
    uint8_t material;
    Color paint;
    Eigen::Vector3f normal;
  };
  // The same of a triangle where it was, along z.
  struct OldCrossing {
    double depth;
    int triangle;
    bool out;
  };
  using Crossings = std::array<std::vector<Crossing>, 3>;  // of each field's rays
  class Change;
  struct Corner;

  Result<Reshaped> put(const std::vector<WarpMap>& maps);
  Result<Reshaped> keep_volume(std::vector<WarpMap>& maps, double radius, Reshaped result);
  void read(const NodeBox& box);
  NodeBox crossed() const;
  void move_vertices(const std::vector<WarpMap>& maps);
  void move_triangles(const std::vector<WarpMap>& maps);
  void move_triangle(const std::vector<WarpMap>& maps, size_t t, Crossings& to);
  void emit(const std::vector<WarpMap>& maps, const Corner& a, const Corner& b, const Corner& c,
            int depth, Crossings& to);
  void cross(const std::vector<WarpMap>& maps, const Corner& a, const Corner& b, const Corner& c,
             Crossings& to);
  Vec3 turned_normal(const std::vector<WarpMap>& maps, const Corner& at);
  void decide_nodes();
  void decide_nodes_of_row(int j, std::vector<uint32_t>& flagged);
  Reshaped write();
  Reshaped put_node(double radius, const Drag& drag);

  TriDexel& model_;
  int threads_ = 1;
  std::optional<Snapshot> base_;
  uint64_t generation_ = 0;  // of the model as this left it
  bool warped_ = false;
  // Of the base, within box_.
  NodeBox box_;
  std::map<std::array<int, 3>, SurfaceChunk> chunks_;
  std::vector<Vertex> vertices_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint8_t> before_;  // whether nodes are inside
  std::vector<int8_t> mesh_;     // how often the triangles go around them
  std::vector<std::vector<OldCrossing>> columns_;
  // Of the warp.
  bool clipped_ = false;                // a vertex came to lie beyond the lattice
  std::vector<Vec3> moved_;             // vertices
  std::vector<Vec3> turned_;            // their normals, as far as they were asked for
  std::vector<uint8_t> turning_;        // whether they were
  std::vector<uint8_t> stays_, moves_;  // which vertices stay, which triangles move
  Crossings crossings_;
  std::vector<Crossings> pieces_;  // of them, in order
  std::vector<uint8_t> after_, flags_;
  std::vector<uint32_t> flagged_;
  std::vector<uint32_t> outvoted_;  // nodes at which the z field is not believed; in order
};

}  // namespace kibori
