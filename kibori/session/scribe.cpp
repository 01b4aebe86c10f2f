// SPDX-License-Identifier: MIT
#include <kibori/session/scribe.h>

#include <chrono>

namespace kibori {

Scribe::Scribe(LiveCarving& live, std::unique_ptr<Document> document)
    : live_(live), document_(std::move(document)) {}

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
  StrokeLog& log = live_.log();
  StrokeLog::Event event;
  while (log.pop(event)) {
    const bool writes = trouble().empty();
    switch (event.kind) {
      case StrokeLog::Kind::begin: {
        StrokeLog::Begin begin;
        if (!log.pop(begin) || !writes) break;
        const StrokeSettings settings{begin.tool,       begin.mode,  begin.material,
                                      *begin.materials, begin.force, begin.rate_hz};
        if (const Status s = document_->begin(settings, begin.start); !s) fail(s.error());
        break;
      }
      case StrokeLog::Kind::tick:
        if (writes && document_->in_stroke()) document_->add(event.tick);
        break;
      case StrokeLog::Kind::end: {
        StrokeLog::End end;
        if (!log.pop(end) || !writes || !document_->in_stroke()) break;
        if (const Status s = document_->finish(end.state, end.bounds, end.removed_mm3); !s) fail(s.error());
        break;
      }
    }
  }
  // The states that the document remembers hold on to theirs.
  live_.refill();
  if (trouble().empty() && document_->in_stroke())
    if (const Status s = document_->flush(); !s) fail(s.error());
  if (log.lost()) fail(document_->name() + ": could not be written as fast as was carved");
}

std::string Scribe::trouble() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return trouble_;
}

void Scribe::fail(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (trouble_.empty()) trouble_ = why;
}

}  // namespace kibori
