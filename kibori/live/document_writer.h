// SPDX-License-Identifier: MIT
// Two threads that write the strokes of a session into a document. They also execute requests:
// undo, redo and actions on bodies. A fence is an event in the stroke log that marks a request.
//
//   hand:    tick, tick, end ──► stroke log ──► Document ──► file
//   caller:  undo() ──► fence in the stroke log ──► everything before the fence is written
//            ──► state of the step before ──► restored between two ticks ──► document moves to it
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

// Returns the body of a document as ServoContext::set_body needs it. `id` must exist. Errors: those
// of no_go_of.
Result<WorkedBody> worked_body(const BodyList& bodies, BodyId id);

class DocumentWriter {
 public:
  // `live` must log (LiveSettings::log), be in the state of the document's head, and outlive this
  // object. Create this object before live.start(), because it reads the model. If `forces` is
  // true, the forces of every tick are stored, too.
  DocumentWriter(LiveCarving& live, std::unique_ptr<Document> document, bool forces = false);
  ~DocumentWriter() { stop(); }

  // start() starts two threads. The writer writes every 20 ms (every 1 ms during a request). The
  // reader empties the log, so that nothing is lost during a long write. stop() writes the rest.
  // Call LiveCarving::stop() before it. start(), stop() and write() are for the owner's thread.
  void start();
  void stop();
  // Writes everything that is available. For an owner that does not call start().
  void write();

  // Requests. The current stroke ends before them. notice() returns the error of a request. Any
  // thread. (LiveCarving::cancel_stroke() discards a stroke.)
  void undo() { ask(Kind::undo, 0); }
  void redo() { ask(Kind::redo, 0); }
  void go(StepId step) { ask(Kind::go, step); }
  // Applies an action on bodies as a step (Document::act).
  void act(const BodyAction& action) { ask(Kind::act, 0, action); }
  // Calls Document::revise for `step`. It must be on the path to `head`, to which the document
  // moves first.
  void revise(StepId step, StepId head, const BodyAction& action) {
    ask(Kind::revise, step, action, head);
  }
  // Selects the body for later strokes.
  void choose(BodyId body) { ask(Kind::choose, static_cast<StepId>(body)); }
  // Returns true if all requests are done. Any thread.
  bool idle() const { return request_count_.load() == answered_.load(); }

  // Calls f between two writes, on the writer's thread. For example, f adds a version or copies the
  // document. Any thread.
  void with(std::function<void(Document&)> f);

  // Returns the reason why the file does not contain the whole session. Empty if it does. If the
  // disk is full, the document has everything in memory. If the stroke log overflowed, later
  // strokes are lost. In both cases, the session continues. Any thread.
  std::string write_error() const;
  // Returns the reason why the last failed request failed, and clears it. Empty if there is none.
  // Any thread.
  std::string notice();
  // Call this after stop(). If the file does not contain the whole session, saves the document
  // elsewhere. Then returns the reason and the new place for the user. Otherwise, returns an empty
  // text.
  std::string settled();
  // Call this only while no thread runs.
  Document& document() { return *document_; }

 private:
  enum class Kind { undo, redo, go, act, revise, choose };
  struct Request {
    Kind kind;
    StepId step;  // the step, or the body for `choose`
    BodyAction action;
    StepId head;  // for `revise`
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
  // At the fence: finds the target step of the request.
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
  // Members for the writer's thread.
  Snapshot of_model_;               // gives access to the model's pools, which write() refills
  std::optional<Request> request_;  // the current request
  Command waiting_;                 // command that waits for room in the command queue of live_
  std::shared_ptr<Document::Checkout> to_;
  std::deque<Item> unwritten_;
  std::mutex reading_;  // only one thread at a time may read the log
  std::condition_variable request_arrived_;
  mutable std::mutex mutex_;  // guards the members below
  std::deque<Item> items_;
  std::deque<Request> requests_;
  std::deque<std::function<void(Document&)>> calls_;
  std::string write_error_, notice_;
};

}  // namespace kibori
