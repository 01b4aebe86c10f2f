// SPDX-License-Identifier: MIT
// A workpiece as a script works on it: bodies in memory, strokes tool pose by tool pose, back and
// forth, and all of it as a document when that is asked for.
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
  // Makes the stock. Errors: those of make_stock; no materials.
  static Result<std::unique_ptr<Workpiece>> make(const Stock& stock,
                                                 std::vector<Material> materials, int threads);
  // A model that came otherwise. Its documents do not say how it was made, so they can't be carved
  // at another pitch.
  static Result<std::unique_ptr<Workpiece>> of(std::unique_ptr<TriDexel> model,
                                               std::vector<Material> materials);
  // What a document has at its head; the document itself stays as it is. Errors: as of
  // model_at_head.
  static Result<std::unique_ptr<Workpiece>> open(const std::filesystem::path& document);
  ~Workpiece();

  const Bodies& bodies() { return bench_.bodies(); }
  BodyId active() const { return bench_.active(); }
  // Strokes work on that body from then on. Errors: no such body; a stroke is under way.
  Status activate(BodyId body);
  const TriDexel& model() const { return *model_; }
  // What strokes are of; more may be put at its end.
  std::vector<Material>& materials() { return materials_; }
  void set_threads(int threads) { threads_ = threads; }

  // A stroke of the active body, with the tool at `start`. Of `settings`, body and materials are
  // the piece's own. Errors: a stroke is under way already, a body that is locked or no-go, what
  // check_tool, check_symmetry and check_brush_of refuse.
  Status begin(StrokeSettings settings, const Pose& start, const std::string& label = {});
  // The tool goes there; with the force model `series`, the hand does. What came of it. Errors:
  // there is no stroke; those of DirectTool and SpringTool, after which the stroke goes on from
  // where it was; those of ReshapeStroke, after which it can only be cancelled.
  Result<ToolTick> advance(const Pose& to);
  // The stroke is over, and is one step of the history. `last`: the last tick, to which is added
  // what a reshaping mode does at its end; may be null. What it severed.
  Result<CrumbResult> end(ToolTick* last = nullptr);
  // The stroke is as if it had not been.
  void cancel();
  bool in_stroke() const { return stroke_ != nullptr; }
  // Where the tool is in a stroke.
  const Pose& tool_pose() const;

  // What is done with bodies is a step, too. Errors: as of apply(); a stroke is under way.
  Result<BodyChange> act(const BodyAction& action);

  // One step back or forth. Errors: there is none; a stroke is under way.
  Status undo();
  Status redo();
  // Steps since the piece was made or opened: all, and those that are done.
  size_t steps() const { return steps_.size(); }
  size_t done() const { return done_; }

  // The stock, or the document that was opened, and all steps that are done, as a new document.
  // Errors: a file that is there already, unless `overwrite`, and it is a document that nobody
  // writes; those of writing it. Nothing is half written.
  Status save(const std::filesystem::path& path, bool overwrite);

 private:
  struct Stroke;
  // What was done, and what stood there then.
  struct Step {
    std::string label;
    StrokeSettings settings;
    Pose start;
    std::vector<StrokeTick> ticks;
    double removed_mm3 = 0;
    std::vector<Portion> severed;
    std::optional<BodyAction> action;  // instead of a stroke
    Bodies after;
    BodyId began = 1, active = 1;  // the body that was worked on before, and after
  };

  Workpiece(std::unique_ptr<TriDexel> model, Bodies bodies, BodyId active,
            std::vector<Material> materials);
  void keep(Step step);
  void stand_at(size_t done, BodyId active);
  // Into the document: what was done with bodies, done; a stroke, begun and with its ticks.
  Status record(Document& document, const Step& step) const;
  Status write(const std::filesystem::path& path) const;
  Status write_after_opened(const std::filesystem::path& path) const;
  Status no_stroke() const;

  std::unique_ptr<TriDexel> model_;
  Workbench bench_;
  std::vector<Material> materials_;
  int threads_ = 1;
  Bodies first_;  // before any step
  std::vector<Material> first_materials_;
  std::optional<Scene> scene_;  // how the stock was made
  // Or the document that it came from, as it was then, in a folder of its own.
  std::filesystem::path opened_;
  std::shared_ptr<TemporaryFolder> folder_;
  std::vector<Step> steps_;
  size_t done_ = 0;
  std::unique_ptr<Stroke> stroke_;
};

}  // namespace kibori
