// SPDX-License-Identifier: MIT
// Sends ticks over WebSocket to at most 32 readers, as the messages PublishedAbout and
// PublishedTicks of docs/protocol.md. The server has its own thread. A slow reader misses ticks,
// but never delays the servo. The numbers of the ticks show which ticks are missing.
//
// Every program that can connect to the address may read the ticks. Readers cannot change anything.
// A web page may read them only if it comes from this machine or from the host in the address.
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
  // Listens on `address`, which is HOST:PORT. Port 0 selects a free port. Errors: the address is
  // invalid, or is in use.
  static Result<std::unique_ptr<TickServer>> listen(const std::string& address);
  ~TickServer();

  // Returns the address of the server: HOST:PORT.
  const std::string& address() const;
  // Sets the description of the next rows. `json` is the result of about_rows().
  void about(std::string json);
  // Sends rows to all readers. Does not wait.
  void publish(std::span<const TickRow> rows);

 private:
  struct State;
  explicit TickServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
