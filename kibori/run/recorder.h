// SPDX-License-Identifier: MIT
// Stores what a scene carves in a document, during carving. Internal: not installed.
//
// If the file is no longer writable, the document continues in memory. If that fails too, the file
// keeps what it has. Each failure is reported once, as a warning. Carving always continues.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <kibori/document/document.h>
#include <kibori/run/carving.h>

namespace kibori {

class Recorder {
 public:
  // Creates `options.document`; stores nothing if that is empty. `options` must outlive the
  // recorder. Errors: see new_document.
  static Result<Recorder> make(const CarveOptions& options, const Scene& scene,
                               const TriDexel& model);

  // Call after `action` has changed the bodies.
  void act(const BodyAction& action);
  // A stroke: begin, its ticks in order, finish. `computed` is the force by the stroke's force
  // model.
  void begin(const StrokeSettings& settings, const Pose& start, const std::string& label);
  void add(const RecordedTick& tick, const Wrench& computed = {});
  // See Document::finish.
  void finish(const TriDexel& model, double removed_mm3, const std::vector<Portion>& severed);
  // Draws the picture of the last step.
  void draw(const BodyList& bodies, const std::vector<Material>& materials);
  // Writes everything that is pending. Returns why the document holds only the beginning, and where
  // the rest is. Empty if the document is complete.
  std::string settle();

 private:
  explicit Recorder(const CarveOptions& options) : options_(&options) {}
  void check(const Status& kept);

  const CarveOptions* options_;
  std::unique_ptr<Document> document_;  // null: nothing is stored, or storing failed
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  std::string unsaved_;
  bool reported_ = false;
};

}  // namespace kibori
