// SPDX-License-Identifier: MIT
// Parametric strokes. A WarpMap moves the surface from its state at the start of the stroke. Each
// warp begins with that state, so the result depends only on the current parameters. With zero
// parameters, the model equals that state, bit for bit.
//
// A warp moves the triangles of the surface (surface.h). It splits stretched triangles, and
// computes the rays that they cross again. Sharp edges stay sharp. Rays that no moved triangle
// crosses keep their spans. The three fields agree, because the z field decides the nodes. The
// other two fields decide only the positions between nodes.
#pragma once

#include <array>
#include <bitset>
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
  // Call begin() at the start of a stroke. It stores the model's state. Until the next begin(),
  // only this object may change the model.
  explicit Warp(TriDexel& model) : model_(model) {}
  void begin();
  // Sets the number of threads of a warp. It does not change the result.
  void set_threads(int threads) { threads_ = threads; }

  // If `grows` is true, the model's lattice grows when a warp needs room. Otherwise, the material
  // beyond the lattice is cut off. The growth depends on the lattice at begin() and on the current
  // warp, not on earlier warps.
  void set_grows(bool grows) { grows_ = grows; }

  // Sets the model to its state at begin(), warped. The result is relative to that state. `drags`
  // are in mm, one for the hand and one for each of its images. If several drags move a point,
  // their displacements add up. `grab_connected` and `hook` move only connected material: a path
  // through material within the brush's reach must connect it with the drag's centre. Errors:
  // check_brush rejects the brush; a drag is not finite or longer than kMaxDragRadii; its axis or
  // normal is not a unit vector; there are more than kMaxDrags; the region takes too much memory.
  // After an error, the model is unchanged or has its state at begin().
  Result<Reshaped> warp(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags);

  // Maximum displacement of a drag, in radii of the brush.
  static constexpr double kMaxDragRadii = 100;
  static constexpr size_t kMaxDrags = 128;

 private:
  // The maps that may move a point: one bit per map.
  using Movers = std::bitset<kMaxDrags>;
  struct Vertex {
    Vec3 at;
    double share;  // share of the maps' displacement that the mask lets through (unmasked_share)
    std::array<float, 3> normal;
    uint8_t material;
    Color paint;
  };
  // The crossing of a ray with a moved triangle.
  struct Crossing {
    uint64_t ray;  // see ray_key
    double depth;
    bool out;
    uint8_t material;
    Color paint;
    Eigen::Vector3f normal;
  };
  // The crossing of a z ray with an original triangle.
  struct OldCrossing {
    double depth;
    int triangle;
    bool out;
  };
  using Crossings = std::array<std::vector<Crossing>, 3>;  // one list per axis of rays
  class Change;
  struct Corner;

  Result<Reshaped> warp_once(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags);
  Result<Reshaped> put(const std::vector<WarpMap>& maps);
  void restore_base();
  // Returns true if the warp needs a larger lattice, and may enlarge it.
  bool needs_room() const;
  Result<Reshaped> keep_volume(std::vector<WarpMap>& maps, double radius, Reshaped result);
  void read(const NodeBox& box);
  void find_movers();
  static Vec3 mapped(const std::vector<WarpMap>& maps, const Vec3& at, const Movers& movers,
                     double share);
  static Vec3 turned(const std::vector<WarpMap>& maps, const Corner& at);
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
  double depth_below_base(double radius, const Drag& drag, const Mat3& frame, bool into) const;
  uint8_t material_at(const Vec3& point) const;
  Reshaped put_node(double radius, const Drag& drag);

  TriDexel& model_;
  int threads_ = 1;
  std::optional<Snapshot> base_;
  uint64_t generation_ = 0;  // generation of the model after the last warp
  bool warped_ = false, grows_ = false;
  Lattice lattice_;    // lattice of the model in the current warp
  LatticeBox room_;    // the box that lattice_ must contain
  LatticeBox needed_;  // box of the moved surface
  // Data of the model's state at begin(), within box_.
  NodeBox box_;
  std::map<std::array<int, 3>, SurfaceChunk> chunks_;
  std::vector<Vertex> vertices_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint8_t> before_;  // 1 if the node is inside
  std::vector<int8_t> mesh_;     // winding number of the triangles around each node
  std::vector<std::vector<OldCrossing>> columns_;
  // Data of the current warp.
  bool clipped_ = false;                // true if a vertex moved beyond the lattice
  std::vector<GrabReach> reaches_;      // reaches of connected grabs, one per map
  std::vector<Movers> movers_;          // one per vertex
  std::vector<Vec3> moved_;             // moved vertices
  std::vector<Vec3> turned_;            // normals of the moved vertices, computed on demand
  std::vector<uint8_t> turning_;        // state of turned_
  std::vector<uint8_t> stays_, moves_;  // 1 for a vertex that stays; 1 for a triangle that moves
  Crossings crossings_;
  std::vector<Crossings> pieces_;  // parts of crossings_, in the order of the work
  std::vector<uint8_t> after_, flags_;
  std::vector<uint32_t> flagged_;
  // Indices of nodes at which the x and y fields overrule the z field, sorted.
  std::vector<uint32_t> outvoted_;
};

}  // namespace kibori
