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
  std::string to;                  // a version or a step; default: the head
  std::optional<double> pitch_mm;  // pitch of the model; default: as recorded
  std::optional<ForceLaw> law;     // default: as recorded
  CarveOptions carve;              // only threads, force, progress and warning are used
};

// The result of replay_document().
struct Replay {
  Carving carving;
  ForceLaw law;  // force law of the last stroke
  StepId to = 0;
  // The first step whose bodies differ from the recorded ones; 0: none. It is only set at the
  // recorded pitch.
  StepId differs = 0;
};

// Makes the stock of a document at another pitch. `text` is the description of the stock (JSON).
// Errors: `text` is not a description; those of make_stock; a temporary file cannot be written.
Result<std::unique_ptr<TriDexel>> stock_again(const Document& document, const std::string& text,
                                              double pitch_mm, const CarveOptions& options);

// Replays the steps on the path to options.to. Errors: those of the document and of stock_again.
Result<Replay> replay_document(const Document& document, const ReplayOptions& options);

}  // namespace kibori
