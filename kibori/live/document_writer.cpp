// SPDX-License-Identifier: MIT
#include <kibori/live/document_writer.h>

#include <kibori/document/rescue.h>

#include <chrono>

namespace kibori {
namespace {

// Number of threads for an action on bodies. During it, the servo changes nothing.
constexpr int kThreads = 2;

}  // namespace

Result<WorkedBody> worked_body(const BodyList& bodies, BodyId id) {
  const Body& body = *bodies.find(id);
  Result<std::shared_ptr<const NoGo>> no_go = no_go_of(bodies, id);
  if (!no_go) return Error{no_go.error()};
  return WorkedBody{id, body.pose, body.kept(), std::move(no_go).value()};
}

DocumentWriter::DocumentWriter(LiveCarving& live, std::unique_ptr<Document> document, bool forces)
    : live_(live),
      document_(std::move(document)),
      forces_(forces),
      device_(live.context().device().capabilities().name),
      of_model_(live.context().model().snapshot()) {}

void DocumentWriter::start() {
  if (writer_.joinable()) return;
  stopping_ = false;
  reader_ = std::thread([this] {
    while (!stopping_.load(std::memory_order_relaxed)) {
      read();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  writer_ = std::thread([this] {
    while (!stopping_.load(std::memory_order_relaxed)) {
      write();
      std::unique_lock<std::mutex> lock(mutex_);
      if (request_)
        request_arrived_.wait_for(lock, std::chrono::milliseconds(1));
      else
        request_arrived_.wait_for(lock, std::chrono::milliseconds(20),
                                  [this] { return !requests_.empty(); });
    }
  });
}

void DocumentWriter::stop() {
  if (!writer_.joinable()) return;
  stopping_ = true;
  reader_.join();
  writer_.join();
  write();
}

void DocumentWriter::read() {
  StrokeLog& log = live_.log();
  // Only one thread may read at a time.
  const std::lock_guard<std::mutex> lock(reading_);
  StrokeLog::Event event;
  while (log.pop(event)) {
    Item item;
    item.event = event;
    if (event.kind == StrokeLog::Kind::begin) {
      item.begin = std::make_unique<StrokeLog::Begin>();
      log.pop(*item.begin);
    }
    if (event.kind == StrokeLog::Kind::end) {
      item.end = std::make_unique<StrokeLog::End>();
      log.pop(*item.end);
    }
    const std::lock_guard<std::mutex> guard(mutex_);
    items_.push_back(std::move(item));
  }
}

void DocumentWriter::write() {
  read();
  std::deque<std::function<void(Document&)>> calls;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!request_ && !requests_.empty()) {
      request_ = requests_.front();
      requests_.pop_front();
      waiting_ = [](ServoContext& live) { live.fence_log(); };
    }
    calls.swap(calls_);
    for (Item& item : items_) unwritten_.push_back(std::move(item));
    items_.clear();
  }
  if (waiting_ && live_.post(waiting_)) waiting_ = nullptr;
  // If an item cannot be written, not even into memory, it stays in the queue, and so do all later
  // ones.
  Status written = Ok{};
  while (written && !unwritten_.empty()) {
    written = take(unwritten_.front());
    if (written) unwritten_.pop_front();
  }
  // States that the document keeps hold their tiles, so the model's pools need new memory.
  of_model_.keep_ready(ServoContext::kReadyTiles);
  if (written) written = document_->flush();
  for (const auto& call : calls) call(*document_);
  std::string write_error = written ? document_->unsaved() : written.error();
  if (written && !write_error.empty())
    write_error +=
        "; the work continues in memory: make room on the disk, or export the document elsewhere";
  if (live_.log().lost()) {
    write_error = document_->name() +
                  ": the disk was too slow for the carving; work since then is not in any document";
    if (request_) done(Error{write_error});
  }
  publish(&DocumentWriter::write_error_, write_error);
}

Status DocumentWriter::take(const Item& item) {
  switch (item.event.kind) {
    case StrokeLog::Kind::begin: {
      const StrokeLog::Begin& b = *item.begin;
      StrokeSettings settings{b.tool,    b.mode,     b.material, *b.materials,        b.force,
                              b.rate_hz, b.symmetry, b.brush,    document_->active(), b.crumbs,
                              b.second,  device_};
      settings.begin_on(b.lattice);
      return document_->begin(settings, b.start);
    }
    case StrokeLog::Kind::tick:
      document_->add(item.event.tick, forces_ ? &item.event.computed : nullptr,
                     forces_ ? &item.event.given : nullptr);
      return Ok{};
    case StrokeLog::Kind::end:
      return document_->finish(item.end->state, item.end->bounds, item.end->removed_mm3,
                               item.end->crumbs.portions);
    case StrokeLog::Kind::cancel:
      return document_->cancel();
    case StrokeLog::Kind::fence: {
      const Status can = resolve_request();
      if (!can) done(can);
      return Ok{};
    }
    case StrokeLog::Kind::moved: {
      Status there = document_->commit_checkout(*to_);
      if (!there) return there;
      to_.reset();
      done(Ok{});
      return Ok{};
    }
  }
  return Ok{};
}

// The target step of the current request.
Result<StepId> DocumentWriter::resolve() {
  switch (request_->kind) {
    case Kind::undo:
      return document_->before_head();
    case Kind::redo:
      return document_->after_head();
    case Kind::go:
      return request_->step;
    case Kind::act: {
      const Result<BodyChange> acted = document_->act(request_->action, kThreads);
      if (!acted) return Error{acted.error()};
      return document_->head();
    }
    case Kind::revise: {
      if (document_->head() != request_->head) {
        const Result<Document::Checkout> to = document_->checkout(request_->head);
        if (!to) return Error{to.error()};
        if (const Status there = document_->commit_checkout(to.value()); !there)
          return Error{there.error()};
      }
      const Status revised = document_->revise(request_->step, request_->action, kThreads);
      if (!revised) publish(&DocumentWriter::notice_, revised.error());
      return document_->head();
    }
    case Kind::choose: {
      const Status chosen = document_->choose(static_cast<BodyId>(request_->step));
      if (!chosen) return Error{chosen.error()};
      return document_->head();
    }
  }
  return document_->head();
}

Status DocumentWriter::resolve_request() {
  if (!request_) return Ok{};
  const Result<StepId> step = resolve();
  if (!step) return Error{step.error()};
  Result<Document::Checkout> found = document_->checkout(step.value());
  if (!found) return Error{found.error()};
  to_ = std::make_shared<Document::Checkout>(std::move(found).value());
  const Result<WorkedBody> body = worked_body(to_->bodies, to_->active);
  if (!body) return Error{body.error()};
  waiting_ = [to = to_, at = body.value()](ServoContext& live) mutable {
    live.go_to(to->state, to->material_bounds, at);
  };
  if (live_.post(waiting_)) waiting_ = nullptr;
  return Ok{};
}

void DocumentWriter::done(const Status& how) {
  request_.reset();
  if (!how) {
    publish(&DocumentWriter::notice_, how.error());
    waiting_ = [](ServoContext& live) { live.resume(); };
  }
  answered_++;
}

void DocumentWriter::ask(Kind kind, StepId step, const BodyAction& action, StepId head) {
  const std::lock_guard<std::mutex> lock(mutex_);
  request_count_++;
  requests_.push_back({kind, step, action, head});
  request_arrived_.notify_one();
}

void DocumentWriter::with(std::function<void(Document&)> f) {
  const std::lock_guard<std::mutex> lock(mutex_);
  calls_.push_back(std::move(f));
}

std::string DocumentWriter::settled() {
  const bool in_memory = !document_->unsaved().empty();
  const std::string where = settle(*document_);
  return in_memory ? where : write_error();
}

std::string DocumentWriter::write_error() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return write_error_;
}

std::string DocumentWriter::notice() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(notice_, {});
}

void DocumentWriter::publish(std::string DocumentWriter::*what, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  this->*what = text;
}

}  // namespace kibori
