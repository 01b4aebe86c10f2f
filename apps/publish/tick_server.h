// SPDX-License-Identifier: MIT
// Ticks over WebSocket, to whoever asks: messages PublishedAbout and PublishedTicks of
// docs/protocol.md. A thread of its own sends them. A reader that does not keep up loses ticks,
// never the servo: the numbers of the ticks tell which.
//
// Anyone who reaches the address may read, and nobody can change anything. A page in a browser may
// only if it comes from this machine or from the host that is named: other sites' pages are
// refused.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <kibori/base/result.h>

#include <kibori/report/tick_row.h>

namespace kibori {

class TickServer {
 public:
  // address: HOST:PORT; port 0: any that is free. Errors: an address that can't be, or is taken.
  static Result<std::unique_ptr<TickServer>> listen(const std::string& address);
  ~TickServer();

  // Where it listens: HOST:PORT.
  const std::string& address() const;
  // What rows are of from now on: of about_rows().
  void about(std::string json);
  void publish(std::span<const TickRow> rows);

 private:
  struct State;
  explicit TickServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
