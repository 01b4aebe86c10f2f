// SPDX-License-Identifier: MIT
#include <kibori/session/scribe.h>

#include <chrono>

namespace kibori {

Scribe::Scribe(LiveCarving& live, std::unique_ptr<Document> document, bool forces)
    : live_(live), document_(std::move(document)), forces_(forces), of_model_(live.model().snapshot()) {}

void Scribe::start() {
  if (thread_.joinable()) return;
  stopping_ = false;
  thread_ = std::thread([this] {
    while (!stopping_.load(std::memory_order_relaxed)) {
      write();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
}

void Scribe::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
  write();
}

void Scribe::write() {
  std::deque<std::function<void(Document&)>> calls;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!request_ && !requests_.empty()) {
      request_ = requests_.front();
      requests_.pop_front();
      waiting_ = [](LiveCarving& live) { live.log().fence(); };
    }
    calls.swap(calls_);
  }
  if (waiting_ && live_.post(waiting_)) waiting_ = nullptr;
  StrokeLog& log = live_.log();
  StrokeLog::Event event;
  // What can't be written, not even into memory, stays, and all after it.
  Status written = event_ ? take(*event_) : Status(Ok{});
  while (written) {
    event_.reset();
    if (!log.pop(event)) break;
    event_ = event;
    written = take(event);
  }
  // The states that the document remembers hold on to theirs.
  of_model_.keep_ready(LiveCarving::kReadyTiles);
  if (written) written = document_->flush();
  for (const auto& call : calls) call(*document_);
  tell(&Scribe::trouble_, log.lost() ? document_->name() + ": could not be written as fast as was carved"
                          : !written ? written.error()
                                     : document_->unsaved());
}

Status Scribe::take(const StrokeLog::Event& event) {
  StrokeLog& log = live_.log();
  switch (event.kind) {
    case StrokeLog::Kind::begin: {
      if (!begin_ && !log.pop(begin_.emplace())) return Ok{};
      const StrokeLog::Begin& b = *begin_;
      const StrokeSettings settings{b.tool, b.mode, b.material, *b.materials, b.force, b.rate_hz};
      const Status begun = document_->begin(settings, b.start);
      if (begun) begin_.reset();
      return begun;
    }
    case StrokeLog::Kind::tick:
      document_->add(event.tick, forces_ ? &event.felt : nullptr);
      return Ok{};
    case StrokeLog::Kind::end: {
      if (!end_ && !log.pop(end_.emplace())) return Ok{};
      const Status ended = document_->finish(end_->state, end_->bounds, end_->removed_mm3);
      if (ended) end_.reset();
      return ended;
    }
    case StrokeLog::Kind::cancel:
      return document_->cancel();
    case StrokeLog::Kind::fence: {
      const Status can = answer();
      if (!can) done(can);
      return Ok{};
    }
    case StrokeLog::Kind::went: {
      const Status there = document_->went(event.step);
      if (there) done(Ok{});
      return there;
    }
  }
  return Ok{};
}

Status Scribe::answer() {
  if (!request_) return Ok{};
  const Result<StepId> step = request_->kind == Kind::undo   ? document_->before_head()
                              : request_->kind == Kind::redo ? document_->after_head()
                                                             : Result<StepId>(request_->step);
  if (!step) return Error{step.error()};
  Result<Document::Destination> found = document_->destination(step.value());
  if (!found) return Error{found.error()};
  const auto to = std::make_shared<Document::Destination>(std::move(found).value());
  if (to->model) {
    to->model->reserve(LiveCarving::kReadyTiles);
    of_model_ = to->model->snapshot();
  }
  waiting_ = [to](LiveCarving& live) {
    if (to->model)
      live.model().swap(*to->model);
    else
      live.model().restore(*to->state);
    live.model_changed();
    live.log().went(to->step);
  };
  if (live_.post(waiting_)) waiting_ = nullptr;
  return Ok{};
}

void Scribe::done(const Status& how) {
  request_.reset();
  if (!how) tell(&Scribe::notice_, how.error());
  answered_++;
}

void Scribe::ask(Kind kind, StepId step) {
  const std::lock_guard<std::mutex> lock(mutex_);
  asked_++;
  requests_.push_back({kind, step});
}

void Scribe::with(std::function<void(Document&)> f) {
  const std::lock_guard<std::mutex> lock(mutex_);
  calls_.push_back(std::move(f));
}

std::string Scribe::trouble() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return trouble_;
}

std::string Scribe::notice() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(notice_, {});
}

void Scribe::tell(std::string Scribe::*what, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  this->*what = text;
}

}  // namespace kibori
