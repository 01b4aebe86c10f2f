// SPDX-License-Identifier: MIT
#include "apps/studio/session/history_viewer.h"

#include <utility>

#include <kibori/run/documents.h>
#include <kibori/haptics/materials.h>

namespace kibori {
namespace {

// The target of redo from a shown step: the next step on the path to the head, else its newest
// child.
Result<StepId> after(const Document& document, StepId step) {
  if (const auto path = document.path_to(document.head()); path)
    for (size_t i = 0; i + 1 < path.value().size(); i++)
      if (path.value()[i] == step) return path.value()[i + 1];
  for (auto at = document.steps().rbegin(); at != document.steps().rend(); ++at)
    if (at->second.parent == step) return at->first;
  return Error{"nothing follows"};
}

}  // namespace

Result<std::unique_ptr<Session>> HistoryViewer::make(std::unique_ptr<Document> document,
                                                     BodyList at_head, const std::string& notice) {
  std::unique_ptr<HistoryViewer> viewer(new HistoryViewer);
  viewer->name_ = document->name();
  viewer->materials_ = document_materials(*document);
  if (viewer->materials_.empty()) viewer->materials_ = known_materials();
  if (const uint8_t own = document_material(*document); own < viewer->materials_.size())
    viewer->stock_material_ = own;
  const BodyId first = at_head.all.front().id;
  viewer->begin({std::move(at_head), first}, removed_until(*document, document->head()));
  viewer->history_.step = document->head();
  PastSteps past;
  for (const auto& [id, step] : document->steps())
    viewer->steps_.push_back(past.of(*document, step));
  viewer->versions_ = document->versions();
  viewer->document_ = std::move(document);
  viewer->notice_ = notice;
  return std::unique_ptr<Session>(std::move(viewer));
}

Result<std::unique_ptr<Session>> HistoryViewer::at_last_whole(const std::filesystem::path& file,
                                                              std::unique_ptr<Document> damaged,
                                                              const std::string& why) {
  const StepId head = damaged->head();
  const Result<StepId> whole = damaged->last_whole();
  damaged.reset();
  if (!whole) return Error{whole.error()};
  auto document = Document::open(file, Document::Access::read);
  if (!document) return Error{document.error()};
  if (const Status there = document.value()->view_step(whole.value()); !there)
    return Error{there.error()};
  auto bodies = document.value()->load_bodies(whole.value());
  if (!bodies) return Error{bodies.error()};
  return make(std::move(document).value(), std::move(bodies).value(),
              why + ". The studio shows step " + std::to_string(whole.value()) + " of " +
                  std::to_string(head) +
                  ", the last undamaged one, read-only; 'kibori history FILE --salvage NEW.kibori' "
                  "saves the steps up to it.");
}

bool HistoryViewer::latest(Shown& shown) {
  if (!fresh_) return false;
  shown.active = fresh_->all.front().id;
  shown.bodies = *std::exchange(fresh_, std::nullopt);
  return true;
}

void HistoryViewer::undo() {
  const StepId before = document_->steps().at(history_.step).parent;
  if (before != 0) look_at(before);
}

void HistoryViewer::redo() { look_at(after(*document_, history_.step)); }

void HistoryViewer::go(StepId step) { look_at(step); }

void HistoryViewer::look_at(const Result<StepId>& step) {
  if (!step || step.value() == history_.step) return;
  auto bodies = document_->load_bodies(step.value());
  if (!bodies) return notify(Error{bodies.error()});
  fresh_ = std::move(bodies).value();
  history_.step = step.value();
}

void HistoryViewer::update_history() {
  const Step& step = document_->steps().at(history_.step);
  history_.steps = document_->steps().size();
  history_.undo = step.parent != 0;
  history_.redo = after(*document_, history_.step).ok();
  history_.hash = step.hash;
}

void HistoryViewer::thumbnail(StepId step, std::function<void(Bytes)> use) {
  Result<Bytes> png = document_->thumbnail(step);
  use(png ? std::move(png).value() : Bytes());
}

void HistoryViewer::save_copy(const std::filesystem::path& path, std::function<void(Status)> done) {
  done(document_->save_copy(path));
}

}  // namespace kibori
