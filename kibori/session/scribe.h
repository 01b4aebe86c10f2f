// SPDX-License-Identifier: MIT
// The thread that writes a hand's strokes into a document while it carves.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <kibori/document/document.h>
#include <kibori/session/live_carving.h>

namespace kibori {

class Scribe {
 public:
  // `live` must log (LiveSettings::log) and stand at the document's head; it must outlive the scribe.
  Scribe(LiveCarving& live, std::unique_ptr<Document> document);
  ~Scribe() { stop(); }

  // Writes what there is every 20 ms, on a thread of its own; stop() writes the rest. After
  // LiveCarving::stop() that is all there was.
  void start();
  void stop();
  // Without a thread: writes what there is.
  void write();

  // Why writing ended early: a full disk, a log that ran over; empty if all is well. The session goes on;
  // what the file has, it keeps. Any thread.
  std::string trouble() const;
  // While no thread runs.
  Document& document() { return *document_; }

 private:
  void fail(const std::string& why);

  LiveCarving& live_;
  std::unique_ptr<Document> document_;
  std::thread thread_;
  std::atomic<bool> stopping_{false};
  mutable std::mutex mutex_;  // of trouble_
  std::string trouble_;
};

}  // namespace kibori
