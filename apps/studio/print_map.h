// SPDX-License-Identifier: MIT
// Finds the print problems of the active body, and shows them as colours and numbers.
#pragma once

#include <array>
#include <map>
#include <memory>

#include <kibori/report/print_check.h>

#include "apps/studio/messages.h"
#include "apps/studio/surface_map.h"

namespace kibori::studio {

class PrintMap final : public SurfaceMap {
 public:
  // Checks the body in its pose in the world. Sets `up` of the options.
  PrintMap(const Body& body, const PrintCheckOptions& options, StepId step);

  BodyId body() const override { return body_; }
  bool is_of(const kibori::BodyList& bodies, BodyId worked_on, StepId step) const override;
  SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) override;
  std::vector<uint8_t> message(double volume_mm3) const override;

 private:
  struct Part {
    std::array<double, 4> area{};  // [mm^2], for each PrintFault
    double thinnest = 0;           // [mm]; infinite: there is no wall
  };

  BodyId body_;
  Pose pose_;
  StepId step_;
  PrintCheck check_;
  std::map<Index3, Part, ChunkOrder> parts_;
};

}  // namespace kibori::studio
