// SPDX-License-Identifier: MIT
// Repeats the steps of a document: as recorded, at another pitch, or with another force model.
#pragma once

#include <optional>
#include <string>

#include <kibori/base/result.h>
#include <kibori/document/document.h>
#include <kibori/run/carving.h>

namespace kibori {

// Options of replay_document().
struct ReplayOptions {
  std::string to;                  // a version or step; default: the head
  std::optional<double> pitch_mm;  // of the model; default: as recorded
  std::optional<ForceLaw> law;     // default: as recorded
  CarveOptions carve;              // threads, progress, warnings
};

// Result of replay_document().
struct Replay {
  Carving carving;
  ForceLaw law;  // of the last stroke
  StepId to = 0;
  // The first step whose model differs from the recorded one. Only checked at the recorded pitch.
  StepId differs = 0;
};

// Errors: those of the document, and a stock that cannot be made at another pitch.
Result<Replay> replay_document(const Document& document, const ReplayOptions& options);

}  // namespace kibori
