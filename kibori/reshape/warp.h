// SPDX-License-Identifier: MIT
// Parametric strokes: a WarpMap moves the surface from its state at the start of the stroke. It
// always uses that state, so the same parameters give the same model after any sequence of moves.
// With zero parameters, the model equals that state, bit for bit.
//
// The surface's triangles (surface.h) are moved. Stretched ones are split, and the rays that they
// cross are computed again. Sharp edges stay sharp. Rays that no moved triangle crosses keep their
// spans. The three fields agree: the z field decides the nodes, and the other two only the
// positions between them.
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
  // begin() starts a stroke on the current model. Until the next begin(), nothing else may change
  // the model.
  explicit Warp(TriDexel& model) : model_(model) {}
  void begin();
  // Number of threads of a warp. It does not change the result.
  void set_threads(int threads) { threads_ = threads; }

  // Sets whether the model's lattice grows if a warp needs room. Otherwise, the material beyond it
  // is cut off. The growth depends only on the lattice at begin() and on this warp, not on the
  // warps between.
  void set_grows(bool grows) { grows_ = grows; }

  // Sets the model to its state at begin(), warped. The result is relative to that state. `drags`
  // are in mm, for the hand and its images. If several reach a point, their displacements add up.
  // `grab_connected` and `hook` move only the surface of connected material. It must be connected,
  // within the brush's reach, with the material at the drag's centre. Errors: a brush that
  // check_brush rejects, a drag that is not finite or longer than kMaxDragRadii, more than
  // kMaxDrags, or too little memory for the region. An error leaves the model unchanged.
  Result<Reshaped> warp(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags);

  static constexpr double kMaxDragRadii = 100;
  static constexpr size_t kMaxDrags = 128;

 private:
  // The maps that may move a point.
  using Movers = std::bitset<kMaxDrags>;
  struct Vertex {
    Vec3 at;
    double share;  // of the maps' displacement: unmasked_share
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
  // A crossing of an original triangle with a z ray.
  struct OldCrossing {
    double depth;
    int triangle;
    bool out;
  };
  using Crossings = std::array<std::vector<Crossing>, 3>;  // of each field's rays
  class Change;
  struct Corner;

  Result<Reshaped> warp_once(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags);
  Result<Reshaped> put(const std::vector<WarpMap>& maps);
  void restore_base();
  // True if the warp needs a larger lattice, and can have it.
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
  uint64_t generation_ = 0;  // of the model after the last warp
  bool warped_ = false, grows_ = false;
  Lattice lattice_;    // of the model in this warp
  LatticeBox room_;    // the box that lattice_ must contain
  LatticeBox needed_;  // box of the moved surface
  // Data of the base, within box_.
  NodeBox box_;
  std::map<std::array<int, 3>, SurfaceChunk> chunks_;
  std::vector<Vertex> vertices_;
  std::vector<std::array<uint32_t, 3>> triangles_;
  std::vector<uint8_t> before_;  // true if the node is inside
  std::vector<int8_t> mesh_;     // winding number of the triangles around each node
  std::vector<std::vector<OldCrossing>> columns_;
  // Data of the current warp.
  bool clipped_ = false;                // a vertex moved beyond the lattice
  std::vector<GrabReach> reaches_;      // of grab_connected, for each map
  std::vector<Movers> movers_;          // of each vertex
  std::vector<Vec3> moved_;             // vertices
  std::vector<Vec3> turned_;            // their normals, computed on demand
  std::vector<uint8_t> turning_;        // state of turned_
  std::vector<uint8_t> stays_, moves_;  // vertices that stay, triangles that move
  Crossings crossings_;
  std::vector<Crossings> pieces_;  // parts of crossings_, in order
  std::vector<uint8_t> after_, flags_;
  std::vector<uint32_t> flagged_;
  // nodes at which the other two fields overrule the z field; in order
  std::vector<uint32_t> outvoted_;
};

}  // namespace kibori
