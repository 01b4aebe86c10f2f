// SPDX-License-Identifier: MIT
// Stores the steps of a scene or a milling program in a document during the run. Internal: not
// installed.
//
// If the file is no longer writable, the document continues in memory. If that fails too, the file
// keeps what it has. Only the first failure causes a warning. Carving always continues.
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
  bool keep_forces = false;                                   // also stores forces
  std::function<void(const std::string&)> warning = nullptr;  // one sentence per call
};

class Recorder {
 public:
  // Null: stores nothing.
  Recorder(std::unique_ptr<Document> document, RecordOptions options)
      : options_(std::move(options)), document_(std::move(document)) {}

  // Call after `action` has changed the bodies.
  void act(const BodyAction& action);
  // For each stroke, call begin, add for each tick in order, and finish. `computed` is the force of
  // the stroke's force model.
  void begin(const StrokeSettings& settings, const Pose& start, const std::string& label);
  void add(const RecordedTick& tick, const Wrench& computed = {});
  // See Document::finish.
  void finish(const TriDexel& model, double removed_mm3, const std::vector<Portion>& severed);
  // Draws a picture of the bodies and stores it with the last step.
  void draw(const BodyList& bodies, const std::vector<Material>& materials);
  // Writes everything that is pending. Returns why the document holds only the beginning, and where
  // the rest is. Returns an empty text if the document is complete.
  std::string settle();

 private:
  void check(const Status& kept);

  RecordOptions options_;
  std::unique_ptr<Document> document_;  // null: nothing is stored, or storing failed
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  std::string unsaved_;
  bool reported_ = false;
};

}  // namespace kibori
