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
  // Makes the stock. Errors: those of make_stock; `materials` is empty.
  static Result<std::unique_ptr<Workpiece>> make(const Stock& stock,
                                                 std::vector<Material> materials, int threads);
  // Makes a workpiece of an existing model. Documents of it have no description of the stock, so
  // they cannot be carved again at another pitch. Errors: `materials` is empty.
  static Result<std::unique_ptr<Workpiece>> of(std::unique_ptr<TriDexel> model,
                                               std::vector<Material> materials);
  // Makes a workpiece of the state of a document at its head. The document does not change. Errors:
  // those of document_model; a temporary copy cannot be made.
  static Result<std::unique_ptr<Workpiece>> open(const std::filesystem::path& document);
  ~Workpiece();

  const BodyList& bodies() { return bench_.bodies(); }
  BodyId active() const { return bench_.active(); }
  // Selects the body for later strokes. Errors: there is no such body; a stroke is in progress.
  Status activate(BodyId body);
  const TriDexel& model() const { return *model_; }
  // Returns the materials of strokes. The caller may append materials.
  std::vector<Material>& materials() { return materials_; }
  void set_threads(int threads) { threads_ = threads; }
  // true (default): the lattice grows if a stroke needs more room. false: material beyond the
  // lattice is lost.
  void set_grows(bool grows) { grows_ = grows; }
  bool grows() const { return grows_; }

  // Begins a stroke on the active body, with the tool at `start`. The workpiece replaces the body
  // and the materials of `settings`. Errors: a stroke is in progress; the body is locked or
  // protected; `start` is not a rigid pose; the tool is too large for the pitch; those of
  // check_stroke.
  Status begin(StrokeSettings settings, const Pose& start, const std::string& label = {});
  // Moves the tool to `to`. In the force model `series`, moves the hand there. Returns the result
  // of the tick. Errors: there is no stroke; `to` is not finite; those of StrokePlayer::move_to.
  // After an error of HandTool::move, the stroke can continue. After an error of ReshapeStroke, it
  // can only be cancelled.
  Result<ToolTick> advance(const Pose& to);
  // Ends the stroke, which becomes a step of the history. `last` is the result of the last tick, or
  // null. In some modes that reshape, the model changes once more here, and the change is added to
  // `last`. Returns the severed pieces. Errors: there is no stroke, or it has failed.
  Result<CrumbResult> end(ToolTick* last = nullptr);
  // Discards the current stroke.
  void cancel();
  bool in_stroke() const { return stroke_ != nullptr; }
  // Returns the pose of the tool. Precondition: in_stroke().
  const Pose& tool_pose() const;

  // Applies an action on bodies as a step. Errors: those of apply(); a stroke is in progress.
  Result<BodyChange> act(const BodyAction& action);

  // Move one step back or forward. Errors: there is no such step; a stroke is in progress.
  Status undo();
  Status redo();
  // Returns the number of steps since the workpiece was made or opened, with the steps that are
  // undone.
  size_t steps() const { return steps_.size(); }
  // Returns the number of steps that are not undone.
  size_t done() const { return done_; }

  // Saves the stock (or the opened document), and all steps that are not undone, as a new document.
  // Errors: a stroke is in progress; the path does not end in .kibori; the file exists and
  // `overwrite` is false; the file exists and is not a document, or another program writes it; the
  // file cannot be written. After an error, there is no partial file.
  Status save(const std::filesystem::path& path, bool overwrite);

 private:
  struct Stroke;
  // One step of the history, and the bodies after it.
  struct HistoryStep {
    std::string label;
    StrokeSettings settings;
    Pose start;
    std::vector<RecordedTick> ticks;
    double removed_mm3 = 0;
    std::vector<Portion> severed;
    std::optional<BodyAction> action;  // for an action; nullopt for a stroke
    BodyList after;
    BodyId began = 1, active = 1;  // active body before the step, and after it
  };

  Workpiece(std::unique_ptr<TriDexel> model, BodyList bodies, BodyId active,
            std::vector<Material> materials);
  void keep(HistoryStep step);
  void set_done(size_t done, BodyId active);
  // Adds a step to a document. For a stroke, begins it and adds its ticks; the caller must finish
  // it. For an action, nothing more is needed.
  Status record(Document& document, const HistoryStep& step) const;
  Status write(const std::filesystem::path& path) const;
  Status write_after_opened(const std::filesystem::path& path) const;
  Status no_stroke() const;

  std::unique_ptr<TriDexel> model_;
  Workbench bench_;
  std::vector<Material> materials_;
  int threads_ = 1;
  bool grows_ = true;
  BodyList first_;  // bodies before the first step
  std::vector<Material> first_materials_;
  std::optional<Scene> scene_;  // has the description of the stock, if there is one
  // If a document was opened: a copy of it in its state at that time, in a temporary folder.
  std::filesystem::path opened_;
  std::shared_ptr<TemporaryFolder> folder_;
  std::vector<HistoryStep> steps_;
  size_t done_ = 0;
  std::unique_ptr<Stroke> stroke_;
};

}  // namespace kibori
