// SPDX-License-Identifier: MIT
#include <kibori/run/milling_document.h>

#include <utility>

#include <kibori/run/documents.h>
#include <kibori/run/recorder.h>

namespace kibori {

MillDocument::MillDocument(MillDocumentOptions options) : options_(std::move(options)) {}
MillDocument::~MillDocument() = default;

Status MillDocument::make(const TriDexel& model) {
  Result<std::unique_ptr<Document>> made = new_document(options_.path, options_.materials, model);
  if (!made) return Error{made.error()};
  recorder_ = std::make_unique<Recorder>(std::move(made).value(),
                                         RecordOptions{options_.threads, false, options_.warning});
  return Ok{};
}

Status MillDocument::begin(const TriDexel& model, const MillStep& step) {
  if (!recorder_)
    if (Status made = make(model); !made) return made;
  StrokeSettings settings;
  settings.tool = step.cutter;
  settings.materials = options_.materials;
  settings.force.law.model = ForceModel::energy;
  settings.program = step.program;
  settings.begin_on(model.lattice());
  recorder_->begin(settings, step.start, step.label);
  at_ = step.start;
  in_step_ = true;
  return Ok{};
}

void MillDocument::add(const ToolMotion& motion, const Pose& end, int line) {
  if (!(at_.tip == motion.start.tip && at_.frame == motion.start.frame))
    recorder_->add({PutTick{motion.start}, false, line});
  MoveTick tick;
  tick.tip = end.tip;
  tick.turn = motion.turn_rad;
  tick.edits = true;
  recorder_->add({tick, false, line});
  at_ = end;
}

void MillDocument::end(const TriDexel& model, double removed_mm3) {
  if (std::exchange(in_step_, false)) recorder_->finish(model, removed_mm3, {});
}

Status MillDocument::finish(const TriDexel& model) {
  if (!recorder_)
    if (Status made = make(model); !made) return made;
  recorder_->draw(BodyList::of(model), options_.materials);
  const std::string unsaved = recorder_->settle();
  return unsaved.empty() ? Status(Ok{}) : Status(Error{unsaved});
}

}  // namespace kibori
