// SPDX-License-Identifier: MIT
// What a carver has still to take away: how far the surface of the body that is worked on is from
// what may not be cut, in colours and in numbers.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/measure/distance.h>
#include <kibori/surface/surface.h>

#include "apps/studio/messages.h"
#include "apps/studio/surface_map.h"

namespace kibori::studio {

class RemainsMap final : public SurfaceMap {
 public:
  // A body's surface against all that is no-go besides; null: nothing is, or it can't be measured
  // from there. `volume_mm3`: of the body now.
  static std::unique_ptr<RemainsMap> make(const kibori::Bodies& bodies, BodyId worked_on,
                                          const LiveSurface& surface, double volume_mm3);

  BodyId body() const override { return body_; }
  bool is_of(const kibori::Bodies& bodies, BodyId worked_on, StepId step) const override;
  SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) override;
  std::vector<uint8_t> said(double volume_mm3) const override;

 private:
  struct Part {
    double max = 0, sum = 0, area = 0;  // [mm], [mm^3], [mm^2]
  };
  // What makes a map another one: the body, and of what is no-go its pose and model.
  struct Key {
    BodyId id;
    Pose pose;
    uint64_t hash;
    bool operator==(const Key& other) const {
      return id == other.id && pose.tip == other.pose.tip && pose.frame == other.pose.frame &&
             hash == other.hash;
    }
  };
  static std::vector<Key> key_of(const kibori::Bodies& bodies, BodyId worked_on);

  BodyId body_ = 0;
  std::vector<Key> key_;
  Surface wall_;
  std::optional<DistanceTree> tree_;
  double within_mm3_ = 0;  // of the body, in what may not be cut
  double scale_mm_ = 1;    // the last colour's
  std::map<Index3, Part, ChunkOrder> parts_;
};

}  // namespace kibori::studio
