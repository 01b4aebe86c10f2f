// SPDX-License-Identifier: MIT
// Carves a document again: as it was recorded, at another pitch, or with another force model.
#pragma once

#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/run/carving.h>

namespace kibori {

struct ReplayOptions {
  std::string to;                  // a version or step; by default the head
  std::optional<double> pitch_mm;  // of the model; by default as recorded
  std::optional<ForceLaw> law;     // by default as recorded
  CarveOptions carve;              // threads, progress, warnings
};

struct Replay {
  Carving carving;
  ForceLaw law;  // of the last stroke
  StepId to = 0;
  // The first step whose model is not what it was; only looked for at the recorded pitch.
  StepId differs = 0;
};

// Errors: those of the document; a stock that can't be made at another pitch.
Result<Replay> replay_document(const Document& document, const ReplayOptions& options);

}  // namespace kibori
