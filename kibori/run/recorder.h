// SPDX-License-Identifier: MIT
// Keeps what a scene carves in a document while it is carved. Internal: not installed.
//
// If the file can no longer be written, the document continues in memory; if that fails too, the
// file keeps what it has. Each is reported once, as a warning. Carving itself always goes on.
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
  // Creates `options.document`; keeps nothing if that is empty. `options` must outlive the
  // recorder. Errors: those of new_document.
  static Result<Recorder> make(const CarveOptions& options, const Scene& scene,
                               const TriDexel& model);

  // The bodies were changed by `action`.
  void act(const BodyAction& action);
  // A stroke: begin, its ticks in order, finish. `felt`: by the stroke's force model.
  void begin(const StrokeSettings& settings, const Pose& start, const std::string& label);
  void add(const StrokeTick& tick, const Wrench& felt = {});
  // As of Document::finish.
  void finish(const TriDexel& model, double removed_mm3, const std::vector<Portion>& severed);
  // Draws the picture of the last step.
  void draw(const Bodies& bodies, const std::vector<Material>& materials);
  // Writes all that is pending. Why the document holds only the beginning, and where the rest is;
  // empty: all is there.
  std::string settle();

 private:
  explicit Recorder(const CarveOptions& options) : options_(&options) {}
  void check(const Status& kept);

  const CarveOptions* options_;
  std::unique_ptr<Document> document_;  // null: nothing is kept, or nothing can be any more
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  std::string unsaved_;
  bool reported_ = false;
};

}  // namespace kibori
