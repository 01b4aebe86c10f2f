// SPDX-License-Identifier: MIT
// HTTP connections. Each one requests files, uploads one, or becomes a page's WebSocket. Internal
// to apps/studio.
#pragma once

#include "apps/studio/server_state.h"

namespace kibori::studio {

// Answers the requests of a connection until it ends. Runs on the server's thread.
void serve_http(net::Socket socket, Server::State& server, Entrance& entrance);

}  // namespace kibori::studio
