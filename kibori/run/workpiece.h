// SPDX-License-Identifier: MIT
// A workpiece for scripts. It keeps bodies in memory, makes strokes pose by pose, and has undo and
// redo. It can be saved as a document.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/result.h>
#include <kibori/scene/scene.h>
#include <kibori/body/workbench.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/document/document.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

class Workpiece {
 public:
  // Makes the stock. Errors: those of make_stock, or an empty list of materials.
  static Result<std::unique_ptr<Workpiece>> make(const Stock& stock,
                                                 std::vector<Material> materials, int threads);
  // A workpiece from an existing model. Its documents do not describe how the model was made, so
  // they cannot be carved at another pitch.
  static Result<std::unique_ptr<Workpiece>> of(std::unique_ptr<TriDexel> model,
                                               std::vector<Material> materials);
  // A workpiece with the state of a document at its head. The document itself does not change.
  // Errors: those of document_model; no temporary copy can be made.
  static Result<std::unique_ptr<Workpiece>> open(const std::filesystem::path& document);
  ~Workpiece();

  const BodyList& bodies() { return bench_.bodies(); }
  BodyId active() const { return bench_.active(); }
  // Later strokes act on this body. Errors: no such body, or a stroke is in progress.
  Status activate(BodyId body);
  const TriDexel& model() const { return *model_; }
  // The materials of strokes. The caller may append more.
  std::vector<Material>& materials() { return materials_; }
  void set_threads(int threads) { threads_ = threads; }
  // True (the default): the lattice grows if a stroke needs more space. False: material beyond the
  // lattice is lost.
  void set_grows(bool grows) { grows_ = grows; }
  bool grows() const { return grows_; }

  // Begins a stroke on the active body, with the tool at `start`. Body and materials of `settings`
  // are replaced by the workpiece's own. Errors: a stroke is in progress; the body is locked or
  // protected; `start` is not a rigid pose; the tool is too large for the pitch; those of
  // check_tool, check_symmetry and check_brush_of.
  Status begin(StrokeSettings settings, const Pose& start, const std::string& label = {});
  // Moves the tool to `to`; with the force model `series`, moves the hand there. Returns the result
  // of the tick. Errors: no stroke is in progress. After errors of DirectTool and SpringTool, the
  // stroke continues from its last pose. After errors of ReshapeStroke, it can only be cancelled.
  Result<ToolTick> advance(const Pose& to);
  // Ends the stroke, which becomes one step of the history. `last` is the result of the last tick,
  // or null. Some reshaping modes change the model once more here, and add that to `last`. Returns
  // the severed pieces. Errors: no stroke is in progress, or it has failed.
  Result<CrumbResult> end(ToolTick* last = nullptr);
  // Discards the stroke.
  void cancel();
  bool in_stroke() const { return stroke_ != nullptr; }
  // The tool's pose in a stroke.
  const Pose& tool_pose() const;

  // Applies an action on bodies as a step. Errors: see apply(); a stroke is in progress.
  Result<BodyChange> act(const BodyAction& action);

  // Moves one step back or forward. Errors: there is no such step, or a stroke is in progress.
  Status undo();
  Status redo();
  // Number of steps since the workpiece was made or opened, including undone ones.
  size_t steps() const { return steps_.size(); }
  // Number of these steps that are not undone.
  size_t done() const { return done_; }

  // Saves the stock or the opened document, and all steps that are not undone, as a new document.
  // Errors: the file exists and `overwrite` is false; the file exists and is not a document, or
  // another program writes it; errors of writing. An error leaves no partial file.
  Status save(const std::filesystem::path& path, bool overwrite);

 private:
  struct Stroke;
  // One step, and the bodies after it.
  struct HistoryStep {
    std::string label;
    StrokeSettings settings;
    Pose start;
    std::vector<RecordedTick> ticks;
    double removed_mm3 = 0;
    std::vector<Portion> severed;
    std::optional<BodyAction> action;  // instead of a stroke
    BodyList after;
    BodyId began = 1, active = 1;  // the active body before, and after
  };

  Workpiece(std::unique_ptr<TriDexel> model, BodyList bodies, BodyId active,
            std::vector<Material> materials);
  void keep(HistoryStep step);
  void set_done(size_t done, BodyId active);
  // Adds a step to a document. A stroke is begun and its ticks are added. The caller must finish
  // it. An action needs no further call.
  Status record(Document& document, const HistoryStep& step) const;
  Status write(const std::filesystem::path& path) const;
  Status write_after_opened(const std::filesystem::path& path) const;
  Status no_stroke() const;

  std::unique_ptr<TriDexel> model_;
  Workbench bench_;
  std::vector<Material> materials_;
  int threads_ = 1;
  bool grows_ = true;
  BodyList first_;  // before the first step
  std::vector<Material> first_materials_;
  std::optional<Scene> scene_;  // holds the description of the stock, if there is one
  // If a document was opened: a copy of it at that time, in its own temporary folder.
  std::filesystem::path opened_;
  std::shared_ptr<TemporaryFolder> folder_;
  std::vector<HistoryStep> steps_;
  size_t done_ = 0;
  std::unique_ptr<Stroke> stroke_;
};

}  // namespace kibori
