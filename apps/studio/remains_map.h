// SPDX-License-Identifier: MIT
// Shows the remaining material as colours and numbers: the distance from the active body's surface
// to the protected region.
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
  // Compares a body's surface with all other protected bodies. Returns null if there is none, or if
  // the distance cannot be measured. `volume_mm3` is the current volume of the body.
  static std::unique_ptr<RemainsMap> make(const kibori::BodyList& bodies, BodyId worked_on,
                                          const LiveSurface& surface, double volume_mm3);

  BodyId body() const override { return body_; }
  bool is_of(const kibori::BodyList& bodies, BodyId worked_on, StepId step) const override;
  SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) override;
  std::vector<uint8_t> message(double volume_mm3) const override;

 private:
  struct Part {
    // The largest distance [mm], the sum of distance times area [mm^3], and the area [mm^2].
    double max = 0, sum = 0, area = 0;
  };
  // One input of a map: the active body or a protected body. `hash` is that of a protected body's
  // model. It is 0 for the active body.
  struct Key {
    BodyId id;
    Pose pose;
    uint64_t hash;
    bool operator==(const Key& other) const {
      return id == other.id && pose.tip == other.pose.tip && pose.frame == other.pose.frame &&
             hash == other.hash;
    }
  };
  static std::vector<Key> key_of(const kibori::BodyList& bodies, BodyId worked_on);

  BodyId body_ = 0;
  std::vector<Key> key_;
  Surface wall_;
  std::optional<DistanceTree> tree_;
  double within_mm3_ = 0;  // volume of the body within the protected region
  double scale_mm_ = 1;    // distance that has the last colour
  std::map<Index3, Part, ChunkOrder> parts_;
};

}  // namespace kibori::studio
