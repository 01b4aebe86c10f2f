// SPDX-License-Identifier: MIT
// Two threads that write a hand's strokes into a document during carving, and that undo and redo.
//
//   hand:    tick, tick, end ──► log ──► Document ──► file
//   caller:  undo() ──► fence between two ticks ──► log: everything before it is written
//            state of the step before ──► restored between two ticks ──► log: the document moves
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

// Converts a document's body for ServoContext::set_body. Errors: see no_go_of.
Result<WorkedBody> worked_body(const BodyList& bodies, BodyId id);

class DocumentWriter {
 public:
  // `live` must log (LiveSettings::log) and be in the state of the document's head. It must outlive
  // the document writer. Construct this before live.start(), because it reads the model. `forces`:
  // also store the forces of every tick.
  DocumentWriter(LiveCarving& live, std::unique_ptr<Document> document, bool forces = false);
  ~DocumentWriter() { stop(); }

  // One thread writes every 20 ms (every 1 ms during a request). Another thread empties the log, so
  // that nothing is lost during a long write. stop() writes the rest; call LiveCarving::stop()
  // first. start(), stop() and write() are for the owner's thread.
  void start();
  void stop();
  // For an owner without these threads: writes everything that is available.
  void write();

  // History. The current stroke is finished first. notice() reports what failed. Any thread.
  // (LiveCarving::cancel_stroke() discards a stroke.)
  void undo() { ask(Kind::undo, 0); }
  void redo() { ask(Kind::redo, 0); }
  void go(StepId step) { ask(Kind::go, step); }
  // Applies an action on bodies, as a step (Document::act).
  void act(const BodyAction& action) { ask(Kind::act, 0, action); }
  // Calls Document::revise for `step`, which is on the path to `head`.
  void revise(StepId step, StepId head, const BodyAction& action) {
    ask(Kind::revise, step, action, head);
  }
  // Later strokes act on this body.
  void choose(BodyId body) { ask(Kind::choose, static_cast<StepId>(body)); }
  // True if all requests are done. Any thread.
  bool idle() const { return request_count_.load() == answered_.load(); }

  // Calls f between two writes, on the document writer's thread. For versions, copies, or another
  // file. Any thread.
  void with(std::function<void(Document&)> f);

  // The reason why the file has only the beginning of the session: a full disk, or a stroke log
  // that overflowed. Empty if the file is complete. In both cases the session continues. After a
  // full disk, the document has everything in memory; after an overflow, strokes are lost. Any
  // thread.
  std::string write_error() const;
  // The reason why the last request failed; empty if none did. Reading clears it. Any thread.
  std::string notice();
  // Call after stop(). If the file has only the beginning, saves the document elsewhere. Returns
  // the reason and the new place as a sentence; empty if the file is complete.
  std::string settled();
  // Only while no thread runs.
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
  // At the fence: finds the target step, and the state to restore.
  Result<StepId> resolve();
  Status resolve_request();
  void done(const Status& how);
  void publish(std::string DocumentWriter::*what, const std::string& text);

  LiveCarving& live_;
  std::unique_ptr<Document> document_;
  const bool forces_;
  const std::string device_;  // name of the first hand's device
  std::thread reader_, writer_;
  std::atomic<bool> stopping_{false};
  std::atomic<uint64_t> request_count_{0}, answered_{0};
  // For the writer's thread.
  Snapshot of_model_;               // gives access to the model's pools, to refill them
  std::optional<Request> request_;  // the current request
  Command waiting_;                 // waits for a place in the command queue of `live_`
  std::shared_ptr<Document::Checkout> to_;
  std::deque<Item> unwritten_;
  std::mutex reading_;  // only one thread may read the log at a time
  std::condition_variable request_arrived_;
  mutable std::mutex mutex_;  // guards the members below
  std::deque<Item> items_;
  std::deque<Request> requests_;
  std::deque<std::function<void(Document&)>> calls_;
  std::string write_error_, notice_;
};

}  // namespace kibori
