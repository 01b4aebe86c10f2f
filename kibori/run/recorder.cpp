// SPDX-License-Identifier: MIT
#include <kibori/run/recorder.h>

#include <utility>

#include <kibori/document/rescue.h>
#include <kibori/run/documents.h>

namespace kibori {
namespace {

// Time between writes of ticks to the file. A crash can lose the ticks since the last write.
constexpr auto kFlushEvery = std::chrono::milliseconds(50);

}  // namespace

void Recorder::check(const Status& kept) {
  const std::string why = kept ? document_->unsaved() : kept.error();
  if (!why.empty() && !std::exchange(reported_, true) && options_.warning)
    options_.warning(why +
                     (kept ? "; the document continues in memory" : "; later steps are not saved"));
  if (kept) return;
  unsaved_ = why;
  document_.reset();
}

void Recorder::act(const BodyAction& action) {
  if (!document_) return;
  const Result<BodyChange> done = document_->act(action, options_.threads);
  check(done ? Status(Ok{}) : Status(Error{done.error()}));
}

void Recorder::begin(const StrokeSettings& settings, const Pose& start, const std::string& label) {
  if (document_) check(document_->begin(settings, start, label));
}

void Recorder::add(const RecordedTick& tick, const Wrench& computed) {
  if (!document_) return;
  document_->add(tick, options_.keep_forces ? &computed : nullptr);
  const auto now = std::chrono::steady_clock::now();
  if (now - flushed_ < kFlushEvery) return;
  check(document_->flush());
  flushed_ = now;
}

void Recorder::finish(const TriDexel& model, double removed_mm3,
                      const std::vector<Portion>& severed) {
  if (document_) check(document_->finish(model, removed_mm3, severed));
}

void Recorder::draw(const BodyList& bodies, const std::vector<Material>& materials) {
  if (!document_) return;
  const Status drawn =
      keep_thumbnail(*document_, document_->head(), bodies, materials, options_.threads);
  if (!drawn && options_.warning) options_.warning(drawn.error());
}

std::string Recorder::settle() {
  if (document_) check(document_->flush());
  if (document_) unsaved_ = kibori::settle(*document_);
  return unsaved_;
}

}  // namespace kibori
