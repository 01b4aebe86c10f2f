// SPDX-License-Identifier: MIT
// Stores a milling run as a document. A step is the part of a program that one tool runs. Each move
// is stored with its program line.
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
  std::filesystem::path path;       // path of the new document
  std::vector<Material> materials;  // materials of the model, at least one
  int threads = 1;
  std::function<void(const std::string&)> warning;  // called with one sentence for each warning
};

// One tool that runs a part of one program.
struct MillStep {
  Tool cutter;
  std::string program;  // name of the file, without its folder
  std::string label;    // label of the step
  Pose start;           // pose of the tool at the start
};

// The document of one model. run_milling calls begin(), add() and end(). The first begin() creates
// the file. If the file becomes unwritable, the document continues in memory.
class MillDocument {
 public:
  explicit MillDocument(MillDocumentOptions options);
  ~MillDocument();

  // Begins a step. `model` is the state before the step. Errors: the file cannot be created.
  Status begin(const TriDexel& model, const MillStep& step);
  bool in_step() const { return in_step_; }
  // Adds a sweep of the cutter that ends at `end`. If it does not begin where the last sweep ended,
  // the new position is stored first. `line` is the line of the program.
  void add(const ToolMotion& motion, const Pose& end, int line);
  // Ends the step, if one has begun. `model` is the state after the step.
  void end(const TriDexel& model, double removed_mm3);

  // Returns true if the file was created.
  bool exists() const { return recorder_ != nullptr; }
  // Draws a picture of the result, and writes everything that is pending. If there was no move,
  // creates the file. Call it once, at the end. Errors: the file cannot be created; the document
  // lacks the last moves (the message has the reason, and the place where they are).
  Status finish(const TriDexel& model);

 private:
  Status make(const TriDexel& model);

  MillDocumentOptions options_;
  std::unique_ptr<Recorder> recorder_;
  Pose at_;  // pose of the tool after the last tick
  bool in_step_ = false;
};

}  // namespace kibori
