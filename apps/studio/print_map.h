// SPDX-License-Identifier: MIT
// What a printer would fail at, in colours on the body that is worked on, and in numbers.
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
  // The body, printed as it stands in the world. Options' `up` is set here.
  PrintMap(const Body& body, const PrintCheckOptions& options, StepId step);

  BodyId body() const override { return body_; }
  bool is_of(const kibori::Bodies& bodies, BodyId worked_on, StepId step) const override;
  SurfaceChunk paint(SurfaceChunk chunk, const Index3& at) override;
  std::vector<uint8_t> said(double volume_mm3) const override;

 private:
  struct Part {
    std::array<double, 4> area{};  // [mm^2], of each PrintFault
    double thinnest = 0;           // [mm]; infinite: no wall
  };

  BodyId body_;
  Pose pose_;
  StepId step_;
  PrintCheck check_;
  std::map<Index3, Part, ChunkOrder> parts_;
};

}  // namespace kibori::studio
