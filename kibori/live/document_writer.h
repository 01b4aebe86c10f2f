// SPDX-License-Identifier: MIT
// Two threads that write a hand's strokes into a document while it carves, and go back and forth in
// its history.
//
//   hand:    tick, tick, end ──► log ──► Document ──► file
//   anyone:  undo() ──► fence between two ticks ──► log: all before it is written
//            state of the step before ──► restored between two ticks ──► log: the document is there
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <kibori/document/document.h>
#include <kibori/live/live_carving.h>

namespace kibori {

// One of a document's bodies, as a servo works on it (ServoContext::stand). Errors: as of no_go_of.
Result<WorkedBody> worked_body(const Bodies& bodies, BodyId id);

class DocumentWriter {
 public:
  // `live` must log (LiveSettings::log) and stand at the document's head; it must outlive the
  // document writer. Made before live.start(), as it reads the model. `forces`: what was felt is
  // kept, too, tick by tick.
  DocumentWriter(LiveCarving& live, std::unique_ptr<Document> document, bool forces = false);
  ~DocumentWriter() { stop(); }

  // One thread writes every 20 ms (every 1 ms during a request); another empties the log, so that
  // nothing is lost while writing takes long. stop() writes the rest; call LiveCarving::stop()
  // first. start(), stop() and write() are for the owner's thread.
  void start();
  void stop();
  // Without a thread: writes what there is.
  void write();

  // History. A stroke that is being made is finished first; what can't be done is told by notice().
  // Any thread. (LiveCarving::cancel_stroke() leaves a stroke off.)
  void undo() { ask(Kind::undo, 0); }
  void redo() { ask(Kind::redo, 0); }
  void go(StepId step) { ask(Kind::go, step); }
  // What is done with bodies, as a step (Document::act).
  void act(const BodyAction& action) { ask(Kind::act, 0, action); }
  // Document::revise of the step, on the way to `head`.
  void revise(StepId step, StepId head, const BodyAction& action) {
    ask(Kind::revise, step, action, head);
  }
  // Strokes go to this body from then on.
  void choose(BodyId body) { ask(Kind::choose, static_cast<StepId>(body)); }
  // Whether all that was asked for is done. Any thread.
  bool idle() const { return asked_.load() == answered_.load(); }

  // Calls f between two writes, on the document writer's thread: versions, copies, another place.
  // Any thread.
  void with(std::function<void(Document&)> f);

  // Why the file holds only the beginning: a full disk, a log that ran over; empty if all is well.
  // The session goes on, and but for the log the document has all of it in memory. Any thread.
  std::string trouble() const;
  // Why the last request failed; empty if none did. Reading clears it. Any thread.
  std::string notice();
  // After stop(): saves elsewhere what could not be saved where it belongs. Why the document holds
  // only the beginning, and where the rest is; empty: all is there.
  std::string settled();
  // While no thread runs.
  Document& document() { return *document_; }

 private:
  enum class Kind { undo, redo, go, act, revise, choose };
  struct Request {
    Kind kind;
    StepId step;  // or body
    BodyAction action;
    StepId head;  // of revise
  };
  using Command = std::function<void(ServoContext&)>;

  struct Item {
    StrokeLog::Event event;
    std::unique_ptr<StrokeLog::Begin> begin;
    std::unique_ptr<StrokeLog::End> end;
  };

  void ask(Kind kind, StepId step, const BodyAction& action = {}, StepId head = 0);
  void read();
  Status take(const Item& item);
  // At the fence: where to, and the way there.
  Result<StepId> resolve();
  Status resolve_request();
  void done(const Status& how);
  void publish(std::string DocumentWriter::*what, const std::string& text);

  LiveCarving& live_;
  std::unique_ptr<Document> document_;
  const bool forces_;
  const std::string device_;  // that the first hand holds
  std::thread reader_, writer_;
  std::atomic<bool> stopping_{false};
  std::atomic<uint64_t> asked_{0}, answered_{0};
  // Of the writer's thread.
  Snapshot of_model_;               // whose memory is refilled
  std::optional<Request> request_;  // that is being answered
  Command waiting_;                 // for a place among the commands of `live_`
  std::shared_ptr<Document::Checkout> to_;
  std::deque<Item> unwritten_;
  std::mutex reading_;  // the log
  std::condition_variable was_asked_;
  mutable std::mutex mutex_;  // of the rest
  std::deque<Item> items_;
  std::deque<Request> requests_;
  std::deque<std::function<void(Document&)>> calls_;
  std::string trouble_, notice_;
};

}  // namespace kibori
