// SPDX-License-Identifier: MIT
// Accepts TLS connections, and passes each one on as a plain stream of bytes. Internal to
// apps/studio.
//
//   device == TLS ==> Link == a pair of local sockets ==> HttpConnection
//
// Therefore, HttpConnection and Boost.Beast need to handle only one type of stream.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/net/web.h>

#include "apps/studio/door.h"

namespace kibori::studio {

class TlsListener {
 public:
  // Listens on `port` of each address. Port 0 selects a free port. `pem` has the key and the
  // certificate. During its handshake, a connection is a stranger of `guests`. The handshake must
  // end within `handshake`. `guests` must outlive the loop. Errors: the certificate cannot be used;
  // an address is not of this machine; the port is in use.
  static Result<std::unique_ptr<TlsListener>> listen(
      net::Loop& loop, const std::vector<std::string>& addresses, uint16_t port,
      const std::string& pem, GuestList& guests, net::Duration handshake,
      std::function<void(net::Socket)> on_connection);
  ~TlsListener();
  uint16_t port() const;

 private:
  struct State;
  explicit TlsListener(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

}  // namespace kibori::studio
