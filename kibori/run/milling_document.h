// SPDX-License-Identifier: MIT
// Stores a milling run as a document: a step for each tool of each program, and the program line of
// every move.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/material.h>
#include <kibori/motion/substeps.h>
#include <kibori/solid/tool.h>

namespace kibori {

class Recorder;

struct MillDocumentOptions {
  std::filesystem::path path;       // of the new document
  std::vector<Material> materials;  // of the model, at least one
  int threads = 1;
  std::function<void(const std::string&)> warning;  // one sentence per call
};

// A step: one tool that runs a part of one program.
struct MillStep {
  Tool cutter;
  std::string program;  // file name, without its folder
  std::string label;    // of the step
  Pose start;           // of the tool
};

// The document of one model. run_milling calls begin, add and end. The first begin() creates the
// file. If the file is no longer writable, the document continues in memory.
class MillDocument {
 public:
  explicit MillDocument(MillDocumentOptions options);
  ~MillDocument();

  // Begins a step. `model` is the state before it. Errors: the file cannot be created.
  Status begin(const TriDexel& model, const MillStep& step);
  bool in_step() const { return in_step_; }
  // Adds a sweep of the cutter that ends at `end`. If it does not begin where the last one ended,
  // the new position is stored first. `line`: the line of the program.
  void add(const ToolMotion& motion, const Pose& end, int line);
  // Ends the step, if one has begun. `model` is the state after it.
  void end(const TriDexel& model, double removed_mm3);

  // True if the file was created.
  bool exists() const { return recorder_ != nullptr; }
  // Draws a picture of the result and writes everything that is pending. Call it once, at the end.
  // Creates the file if there was no move. Errors: the file cannot be created; or the reason why
  // the document holds only the beginning, and where the rest is.
  Status finish(const TriDexel& model);

 private:
  Status make(const TriDexel& model);

  MillDocumentOptions options_;
  std::unique_ptr<Recorder> recorder_;
  Pose at_;  // of the tool, after the last tick
  bool in_step_ = false;
};

}  // namespace kibori
