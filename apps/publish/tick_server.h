// SPDX-License-Identifier: MIT
// Sends ticks over WebSocket to up to 32 readers: the messages PublishedAbout and PublishedTicks of
// docs/protocol.md. It sends on its own thread. A slow reader misses ticks but never delays the
// servo. The tick numbers show which are missing.
//
// Every program that reaches the address may read. Readers cannot change anything. A web page may
// read only if it comes from this machine or from the given host.
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
  // `address` is HOST:PORT. Port 0 chooses a free one. Errors: an invalid address, or one in use.
  static Result<std::unique_ptr<TickServer>> listen(const std::string& address);
  ~TickServer();

  // The address it listens on: HOST:PORT.
  const std::string& address() const;
  // Sets the description of the following rows. `json` comes from about_rows().
  void about(std::string json);
  void publish(std::span<const TickRow> rows);

 private:
  struct State;
  explicit TickServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
