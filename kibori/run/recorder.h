// SPDX-License-Identifier: MIT
// Stores the steps of a scene or a milling program in a document while they run. Internal: not
// installed.
//
// If the file becomes unwritable, the document continues in memory. If this also fails, the file
// has the steps up to then. Only the first failure causes a warning. The run always continues.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <kibori/document/document.h>
#include <kibori/geometry/material.h>

namespace kibori {

struct RecordOptions {
  int threads = 1;                                            // does not change the result
  bool keep_forces = false;                                   // also store forces
  std::function<void(const std::string&)> warning = nullptr;  // gets one sentence per warning
};

class Recorder {
 public:
  // If `document` is null, the recorder stores nothing.
  Recorder(std::unique_ptr<Document> document, RecordOptions options)
      : options_(std::move(options)), document_(std::move(document)) {}

  // Call this after `action` has changed the bodies.
  void act(const BodyAction& action);
  // For each stroke, call begin(), then add() for each tick in order, then finish(). `computed` is
  // the force of the stroke's force model.
  void begin(const StrokeSettings& settings, const Pose& start, const std::string& label);
  void add(const RecordedTick& tick, const Wrench& computed = {});
  // See Document::finish.
  void finish(const TriDexel& model, double removed_mm3, const std::vector<Portion>& severed);
  // Draws a picture of the bodies, and stores it with the last step.
  void draw(const BodyList& bodies, const std::vector<Material>& materials);
  // Writes everything that is pending. If the document lacks the last steps, returns the reason and
  // the place where they are. Otherwise, returns an empty text.
  std::string settle();

 private:
  void check(const Status& kept);

  RecordOptions options_;
  std::unique_ptr<Document> document_;  // null: nothing is stored, or storing has failed
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  std::string unsaved_;
  bool reported_ = false;
};

}  // namespace kibori
